//! Threads beside the loop (safety requirement 022: the loop waits for nothing).

use std::io;
use std::thread;

use rustix::process::getpriority_process;
use thread_priority::unix::set_thread_priority_and_policy;
use thread_priority::{NormalThreadSchedulePolicy, ThreadPriority, ThreadSchedulePolicy, thread_native_id};

/// Starts a thread beside the loop. It may run whenever a processor is free, but when the loop wakes it, the loop goes on
/// first: Linux lets no thread of the policy `SCHED_BATCH` displace one of the ordinary policy (sched(7)). Without that,
/// each plugin that the loop wakes would run before the loop has answered the vehicle.
///
/// # Errors
/// If it cannot start.
pub(crate) fn spawn(name: impl Into<String>, work: impl FnOnce() + Send + 'static) -> io::Result<()> {
    let thread = thread::Builder::new().name(name.into());
    let _detached = thread.spawn(move || {
        // If the system forbids this, the thread displaces the loop now and then, for less than a millisecond.
        if let Some(priority) = getpriority_process(None).ok().and_then(priority) {
            let batch = ThreadSchedulePolicy::Normal(NormalThreadSchedulePolicy::Batch);
            let _forbidden = set_thread_priority_and_policy(thread_native_id(), priority, batch);
        }
        work();
    })?;
    Ok(())
}

/// What the crate calls this niceness, -20 to 19. The crate sets both at once, and the niceness stays as it is.
fn priority(nice: i32) -> Option<ThreadPriority> {
    // It divides its own range, 0 to 99 and the other way round, into the 39 steps of the niceness.
    let share = (f64::from(nice) + 20.5) / 39.0;
    let value = (99.0 * (1.0 - share)).round().clamp(0.0, 99.0) as u8;
    value.try_into().ok().map(ThreadPriority::Crossplatform)
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::sync::mpsc::channel;

    use super::*;

    #[test]
    fn the_niceness_stays_as_it_is() {
        let batch = ThreadSchedulePolicy::Normal(NormalThreadSchedulePolicy::Batch);
        for nice in -20..=19 {
            assert_eq!(priority(nice).unwrap().to_posix(batch).unwrap(), nice);
        }
    }

    #[test]
    fn sr_022_a_thread_beside_the_loop_does_not_displace_it() {
        let (tell, told) = channel();
        spawn("aside", move || {
            let stat = fs::read_to_string("/proc/thread-self/stat").unwrap();
            // What follows the name in brackets (proc(5)) begins with field 3.
            let (_, fields) = stat.rsplit_once(')').unwrap();
            let fields: Vec<&str> = fields.split_whitespace().collect();
            let (nice, policy) = (fields[19 - 3].to_owned(), fields[41 - 3].to_owned());
            tell.send((nice, policy)).unwrap();
        })
        .unwrap();
        const SCHED_BATCH: &str = "3";
        let (nice, policy) = told.recv().unwrap();
        let own = getpriority_process(None).unwrap().to_string();
        assert_eq!((nice, policy.as_str()), (own, SCHED_BATCH));
    }
}
