//! Speed of the spectrum from a series: 45001 points in four columns, all of them reference points,
//! on two threads beside one.

use std::hint::black_box;
use std::time::{Duration, Instant};

use stickslip::math;
use stickslip_series::{DataSettings, Series, data_spectrum};

const POINTS: usize = 45_001;
const DT: f64 = 0.2;

/// A torus in four dimensions whose fast angle is the sum of two: some seventy points in a ball of
/// a tenth of the spread.
fn series() -> Option<Series> {
    let rows = (0..POINTS).map(|i| {
        let (a, b) = (DT * i as f64, 1.618_033_988_749_895 * DT * i as f64);
        [
            math::sin(a),
            math::cos(a),
            math::sin(b) + 0.3 * math::sin(a),
            math::cos(b),
        ]
    });
    Series::from_rows(rows, DT).ok()
}

/// Times of the two, measured in turns.
const TURNS: usize = 5;

fn main() {
    let series = series().expect("a series");
    let [one, two] = [1, 2].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().expect("threads")
    });
    for settings in [DataSettings::sano_sawada(), DataSettings::default()] {
        let time = |pool: &rayon::ThreadPool| -> Duration {
            let begin = Instant::now();
            pool.install(|| black_box(data_spectrum(black_box(&series), &settings)))
                .expect("a spectrum");
            begin.elapsed()
        };
        let mut rounds: Vec<[Duration; 2]> = (0..TURNS).map(|_| [time(&one), time(&two)]).collect();
        rounds.sort_by_key(|[one, _]| *one);
        let [one, two] = rounds[TURNS / 2];
        println!(
            "spectrum, {}: one thread {one:.2?}, two threads {two:.2?}, {:.2} times as fast",
            settings.estimator.words(),
            one.as_secs_f64() / two.as_secs_f64()
        );
    }
}
