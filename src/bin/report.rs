//! x
use std::time::Instant;
use stickslip::report::*;
fn main() {
    let t = Instant::now();
    let n = std::sync::atomic::AtomicUsize::new(0);
    let l = ledger::Ledger::compute(&|| {
        n.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
    })
    .unwrap();
    println!("{:?} {:?} {}", t.elapsed(), n, ledger::TICKS);
    for e in &l.entries {
        println!("## {} = {} -> {}", e.claim.id, e.claim.published, e.verdict);
        for x in &e.evidence {
            println!("    {x}");
        }
        if let Some(c) = &e.cause {
            println!("    CAUSE {:?} {}", c.defects, c.text);
        }
    }
    for e in &l.errata {
        println!("{} {} | {} | {}", e.holds, e.place, e.printed, e.correct);
        for s in &e.shown {
            println!("      {} = {:?} {}", s.what, s.value, s.unit);
        }
    }
    println!("{:?}", l.counts());
    println!("{:?} {:?}", l.injection, l.exits);
}
