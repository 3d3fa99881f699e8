//! The one place that writes to stdout.

use carreau::Error;
use std::io::Write;
use std::path::Path;

/// Results go to stdout; a reader that has gone away is no failure.
pub fn print(text: &[u8]) -> Result<(), Error> {
    let mut stdout = std::io::stdout().lock();
    // What is left in the buffer at the end of the process would be lost without a word.
    match stdout.write_all(text).and_then(|()| stdout.flush()) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => Err(Error::write(Path::new("stdout"), e)),
        _ => Ok(()),
    }
}
