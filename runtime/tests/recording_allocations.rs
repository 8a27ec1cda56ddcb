//! Recording allocates nothing in a step once it is warm.
#![allow(clippy::unwrap_used)]

mod recording_support;

use std::{
    alloc::{GlobalAlloc, Layout, System},
    cell::Cell,
};

use orienteer_runtime::recording::{ChunkLimits, Recorder, Sink};
use recording_support as made_up;

thread_local! {
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
}

/// Counts the allocations of each thread.
struct Counting;

fn count() {
    let _ = ALLOCATIONS.try_with(|count| count.set(count.get() + 1));
}

// SAFETY: everything is left to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count();
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count();
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn a_warm_step_allocates_nothing() {
    let mut recorder = Recorder::start(Sink::Hash, &made_up::mission(2), ChunkLimits::default()).unwrap();
    let mut tracks = made_up::tracks(2);
    let steps: Vec<_> = (0..3000).map(|number| (made_up::step(0, number), made_up::grid(0, number))).collect();
    let mut counts = Vec::with_capacity(steps.len());
    for (step, grid) in &steps {
        for track in &mut tracks {
            track.begin(step.truth.stamp);
            track.record(&step.scan);
            track.record(&step.odometry);
            track.record(&step.pose);
            track.record(&step.decision);
            track.record(&step.truth);
            track.record_grid("map", grid);
            track.log(tracing::Level::WARN, "avoidance", "something stands in the way");
            recorder.append(track.entries());
        }
        counts.push(ALLOCATIONS.get());
    }
    assert!(counts[0] > 0, "the allocations of this thread are not counted");
    // 15 s fit into the batches that may wait for the disk, however slow it is.
    assert_eq!(counts[300] - counts[10], 0);
    // Beyond, the thread may have to wait for the disk, for which the channel makes itself a waiting list, once.
    assert!(counts[2999] - counts[300] <= 4, "{} allocations", counts[2999] - counts[300]);
    recorder.finish().unwrap();
}
