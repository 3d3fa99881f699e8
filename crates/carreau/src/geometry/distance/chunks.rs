//! Many queries in parallel, with looks at the clock.

use crate::context::Context;
use crate::error::Result;
use rayon::prelude::*;

/// Queries between two looks at the clock.
pub const QUERIES_PER_CHECK: usize = 1024;

/// What chunks give, in parallel and in order, looking at the clock between them.
pub fn of_chunks<T: Sync, R: Send>(items: &[T], context: &Context, of: impl Fn(&[T]) -> R + Sync) -> Result<Vec<R>> {
    let of = |chunk: &[T]| {
        context.check()?;
        Ok(of(chunk))
    };
    items.par_chunks(QUERIES_PER_CHECK).map(of).collect()
}

/// Maps in parallel, in order, looking at the clock between chunks; the items of a chunk hand on something.
pub fn map_chunks<T: Sync, R: Send, S: Default>(
    items: &[T],
    context: &Context,
    map: impl Fn(&T, &mut S) -> R + Sync,
) -> Result<Vec<R>> {
    let chunks = of_chunks(items, context, |items| {
        let mut handed_on = S::default();
        items.iter().map(|item| map(item, &mut handed_on)).collect::<Vec<R>>()
    })?;
    Ok(chunks.into_iter().flatten().collect())
}
