//! What a verb is.

use crate::common::{Common, CommonValues};
use crate::failure::Failure;
use crate::host::Host;
use crate::outputs::Outputs;
use crate::replay::options_from;
use crate::session::Session;
use carreau::Error;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::path::Path;
use std::sync::Arc;

/// A verb: its flags, as clap fills them in, and what it does with them.
///
/// A run goes through these steps: `files` are checked before anything is read; `options` come from the defaults, the file of
/// `--options` and the flags, in this order, and stand in the record, which replays the run; `work` does the rest.
pub trait Verb {
    /// Its name.
    const NAME: &'static str;

    /// Whether another program may call it (see [`crate::host`]): it has a result that is no file.
    const IS_CALLABLE: bool = true;

    /// What replays a run, beside the options that all verbs have.
    type Options: Serialize + DeserializeOwned;

    /// The flags that all verbs have.
    fn common(&self) -> &Common;

    /// The same, for a host to enter itself.
    fn common_mut(&mut self) -> &mut Common;

    /// The file that failures are about, if it is one.
    fn subject(&self) -> Option<&Path> {
        None
    }

    /// The files of a run.
    fn files(&self) -> Outputs;

    /// The options where neither a file nor a flag says otherwise.
    fn defaults(&self) -> Self::Options;

    /// Lays the flags over the options, and refuses what does not go together.
    fn lay_over(&self, _options: &mut Self::Options) -> Result<(), Error> {
        Ok(())
    }

    /// Does it.
    fn work(&self, session: &mut Session, options: &Self::Options) -> Result<(), Error>;
}

/// All options of a run, as the record has them.
#[derive(Serialize, Deserialize)]
struct Replayed<O> {
    #[serde(flatten)]
    own: O,
    #[serde(flatten)]
    common: CommonValues,
}

/// A verb of whatever kind.
pub trait Run {
    /// Does it, once it is known that its results can be written. `whole` is the command line as a whole, for verbs that are
    /// about it.
    fn run(&self, whole: fn() -> clap::Command) -> Result<(), Failure>;

    /// Lets it run in a host; false for verbs that do not.
    fn run_in(&mut self, host: &Arc<Host>) -> bool;
}

impl<V: Verb> Run for V {
    fn run(&self, _: fn() -> clap::Command) -> Result<(), Failure> {
        self.files().check()?;
        let common = self.common();
        let base = Replayed { own: self.defaults(), common: CommonValues::default() };
        let mut options = options_from(common.options.as_deref(), V::NAME, base)?;
        self.lay_over(&mut options.own)?;
        options.common = common.over(options.common);
        Session::run(V::NAME, common, &options.common, self.subject(), |session| {
            session.record.set("options", &options);
            self.work(session, &options.own)
        })
    }

    fn run_in(&mut self, host: &Arc<Host>) -> bool {
        if V::IS_CALLABLE {
            self.common_mut().host = Some(Arc::clone(host));
        }
        V::IS_CALLABLE
    }
}
