//! Runs jobs in parallel on all cores.

use super::SuiteError;
use std::sync::Mutex;
use std::thread;

/// Runs `job` for each item. Returns the results in the order of the items, or the first error.
pub(super) fn on_all_cores<T: Sync, R: Send>(
    work: &[T],
    job: impl Fn(&T) -> Result<R, SuiteError> + Sync,
) -> Result<Vec<R>, SuiteError> {
    let next = Mutex::new(work.iter().enumerate());
    let results = Mutex::new(Vec::new());
    let cores = thread::available_parallelism().map_or(1, std::num::NonZero::get);
    thread::scope(|scope| {
        for _ in 0..cores {
            scope.spawn(|| {
                loop {
                    let taken = next.lock().ok().and_then(|mut next| next.next());
                    let Some((index, item)) = taken else { return };
                    let result = job(item);
                    if let Ok(mut results) = results.lock() {
                        results.push((index, result));
                    }
                }
            });
        }
    });
    let mut results = results.into_inner().unwrap_or_default();
    results.sort_by_key(|(index, _)| *index);
    results.into_iter().map(|(_, result)| result).collect()
}
