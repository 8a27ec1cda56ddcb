//! Jobs on several threads, with their results in order.

use std::sync::{
    Mutex, PoisonError,
    atomic::{AtomicU64, Ordering},
};

use super::{Effort, SuiteError};

/// Runs `count` jobs on the effort's threads and returns their results in order, whoever was faster.
///
/// # Errors
/// The error of the first job, in order, that failed.
pub fn in_parallel<T: Send>(
    effort: &Effort,
    what: &str,
    count: u64,
    job: impl Fn(u64) -> Result<T, SuiteError> + Sync,
) -> Result<Vec<T>, SuiteError> {
    let next = AtomicU64::new(0);
    let results: Mutex<Vec<(u64, Result<T, SuiteError>)>> = Mutex::new(Vec::with_capacity(count as usize));
    std::thread::scope(|scope| {
        for _ in 0..effort.threads.max(1) {
            scope.spawn(|| {
                loop {
                    let number = next.fetch_add(1, Ordering::Relaxed);
                    if number >= count {
                        return;
                    }
                    let result = job(number);
                    let mut results = results.lock().unwrap_or_else(PoisonError::into_inner);
                    results.push((number, result));
                    (effort.progress)(what, results.len() as u64, count);
                }
            });
        }
    });
    let mut results = results.into_inner().unwrap_or_else(PoisonError::into_inner);
    results.sort_by_key(|(number, _)| *number);
    results.into_iter().map(|(_, result)| result).collect()
}
