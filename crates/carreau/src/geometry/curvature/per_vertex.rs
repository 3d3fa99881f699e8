//! Values of all vertices, in parallel and in their order.

use crate::context::Context;
use crate::error::{Error, Result};
use rayon::prelude::*;

/// `f` of 0..count, in parallel; the result does not depend on the number of threads.
pub fn map<T: Default + Clone + Send>(
    count: usize,
    context: &Context,
    f: impl Fn(u32) -> T + Send + Sync,
) -> Result<Vec<T>> {
    map_with(count, context, || (), |(), i| f(i))
}

/// [`map`] with a memory for each thread.
pub fn map_with<T: Default + Clone + Send, M>(
    count: usize,
    context: &Context,
    memory: impl Fn() -> M + Send + Sync,
    f: impl Fn(&mut M, u32) -> T + Send + Sync,
) -> Result<Vec<T>> {
    const CHUNK: usize = 2048;
    let mut all = vec![T::default(); count];
    all.par_chunks_mut(CHUNK).enumerate().try_for_each_init(memory, |memory, (k, chunk)| {
        context.check()?;
        for (at, i) in chunk.iter_mut().zip((k * CHUNK) as u32..) {
            *at = f(memory, i);
        }
        Ok::<(), Error>(())
    })?;
    Ok(all)
}
