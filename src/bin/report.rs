use std::time::Instant;
use stickslip::report::*;
fn main() {
    let t = Instant::now();
    let m = matrix::Matrix::compute(&|| ()).unwrap();
    println!("{:?}", t.elapsed());
    for (n, c) in m.named() {
        println!(
            "{n:30} {:?} {} {:?}",
            c.numbers,
            c.class(),
            c.digits.map(|d| d.map(|x| x.to_string()))
        );
    }
    println!("{}", m.sentence());
    for c in m.minimal(matrix::Cell::gives_class) {
        println!("{:?}", c);
    }
    let t = Instant::now();
    let limit = [
        0.469720182696476,
        0.16656657839910888,
        1.174300456741193,
        0.4164164459977755,
    ];
    let c = convergence::Convergence::compute(limit, &|| ()).unwrap();
    println!("{:?} {:?} {:?}", t.elapsed(), c.orders, c.largest_per_step);
    for s in c.steps.iter().chain(&c.around) {
        println!(
            "{:e} {:?} {:?} {}",
            s.h,
            s.numbers
                .map(|n| [0, 1, 2, 3].map(|i| (n[i] - limit[i]) / s.h)),
            s.motion,
            s.gives_digits()
        );
    }
    println!("{}", c.sentence());
    let t = Instant::now();
    let s = scan::Scan::compute([0.4697, 0.1663], &|| ()).unwrap();
    println!("{:?}", t.elapsed());
    for l in &s.lines {
        println!("{:?}", l.parameter);
        for p in &l.points {
            println!(
                "  {:.3} {:?} {}",
                p.factor,
                p.counts,
                p.stick_slip
                    .iter()
                    .map(|m| format!(
                        "[p{} {}:{:.4?} d={:.2}]",
                        m.period,
                        m.lengths.len(),
                        &m.lengths[..m.lengths.len().min(3)],
                        m.distance(s.published)
                    ))
                    .collect::<String>()
            );
        }
    }
    println!("{}", s.sentence());
}
