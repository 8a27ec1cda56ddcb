//! Recording allocates nothing in a step once it is warm.
#![allow(clippy::unwrap_used)]

mod recording_support;

use allocation_counter::measure;
use orienteer_runtime::recording::{ChunkLimits, Recorder, Sink};
use recording_support as made_up;

#[test]
fn a_warm_step_allocates_nothing() {
    let mut recorder = Recorder::start(Sink::Hash, &made_up::mission(2), ChunkLimits::default()).unwrap();
    let mut tracks = made_up::tracks(2);
    let steps: Vec<_> = (0..3000).map(|number| (made_up::step(0, number), made_up::grid(0, number))).collect();
    let mut record = |numbers: std::ops::Range<usize>| {
        let count = measure(|| {
            for (step, grid) in &steps[numbers] {
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
            }
        });
        count.count_total
    };
    assert!(record(0..11) > 0, "the allocations of this thread are not counted");
    // 15 s fit into the batches that may wait for the disk, however slow it is.
    assert_eq!(record(11..301), 0);
    // Beyond, the thread may have to wait for the disk, for which the channel makes itself a waiting list, once.
    let late = record(301..3000);
    assert!(late <= 4, "{late} allocations");
    recorder.finish().unwrap();
}
