//! The `orienteer` command.
use orienteer::{Registry, mission::{self, RunOptions}};
fn main() {
    tracing_subscriber::fmt().with_max_level(tracing::Level::DEBUG).init();
    let path = std::env::args().nth(1).unwrap_or("configs/office-floor.toml".into());
    let registry = Registry::standard();
    let loaded = match mission::load(&path, &registry) { Ok(l) => l, Err(p) => { println!("{p}"); return } };
    let duration = std::env::args().nth(2).and_then(|a| a.parse().ok());
    match mission::run(loaded, &registry, RunOptions { out: Some("out".into()), duration, ..Default::default() }) {
        Ok(o) => {
            println!("{} at x{:.0}, {:?} {:?} {:?}", o.time, o.real_time_factor(), o.elapsed, o.files, o.failures);
            for r in &o.robots { println!("{}: {:?}", r.name, r.facts().collect::<Vec<_>>()); for n in &r.nodes { if n.panics+n.overruns > 0 || n.dropped>0 { println!("  {} panics {} overruns {} dropped {}", n.name, n.panics, n.overruns, n.dropped); } } }
        }
        Err(e) => println!("{e}"),
    }
}
