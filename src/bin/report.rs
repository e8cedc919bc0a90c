//! x
use std::time::Instant;
use stickslip::report::*;
fn main() {
    let t = Instant::now();
    println!("{:?}", injection::Injection::compute());
    println!("{:?} {:?}", injection::Exits::compute(), t.elapsed());
    let t = Instant::now();
    let s = spread::Spread::compute(&|| ()).unwrap();
    println!("{:?} {:?}", t.elapsed(), s.mended);
    for f in &s.figures {
        for i in 0..4 {
            println!("{} {} {:?}", f.figure, i, f.range(i));
        }
    }
    let t = Instant::now();
    let s = scan::Scan::compute([0.4697, 0.1663], &|| ()).unwrap();
    println!("{:?} {:?}", t.elapsed(), s.variants);
    println!("{}", s.sentence());
}
