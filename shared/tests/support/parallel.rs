//! Uses all cores for a long test.

use std::thread;

/// Applies `function` to every item, on all cores. The results are in the order of the items.
///
/// # Panics
/// If `function` panics.
pub fn map<T: Sync, R: Send>(items: &[T], function: impl Fn(&T) -> R + Sync) -> Vec<R> {
    let workers = thread::available_parallelism().map_or(1, usize::from);
    let (items, function) = (&items, &function);
    let mut results: Vec<(usize, R)> = thread::scope(|scope| {
        // Each worker takes every n-th item, because neighbours often take equally long.
        let work = |first| {
            move || {
                let own = items.iter().enumerate().skip(first).step_by(workers);
                own.map(|(number, item)| (number, function(item)))
                    .collect::<Vec<_>>()
            }
        };
        let handles: Vec<_> = (0..workers).map(|first| scope.spawn(work(first))).collect();
        let joined = handles
            .into_iter()
            .map(|handle| handle.join().expect("no panic in a worker"));
        joined.flatten().collect()
    });
    results.sort_by_key(|(number, _)| *number);
    results.into_iter().map(|(_, result)| result).collect()
}
