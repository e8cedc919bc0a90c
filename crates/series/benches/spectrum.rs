//! Speed of the spectrum from a series: 45001 points in four columns, all of them reference points,
//! on one thread and on two.

use std::hint::black_box;
use std::time::Duration;

use criterion::{Criterion, criterion_group};
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

fn benches(criterion: &mut Criterion) {
    let Some(series) = series() else {
        return;
    };
    let mut group = criterion.benchmark_group("data_spectrum");
    for threads in [1, 2] {
        let Ok(pool) = rayon::ThreadPoolBuilder::new().num_threads(threads).build() else {
            continue;
        };
        for settings in [DataSettings::sano_sawada(), DataSettings::default()] {
            let name = format!("{}/threads/{threads}", settings.estimator.words());
            group.bench_function(name, |b| {
                b.iter(|| pool.install(|| data_spectrum(black_box(&series), &settings)));
            });
        }
    }
    group.finish();
}

criterion_group! {
    name = spectra;
    config = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(500))
        .measurement_time(Duration::from_secs(5));
    targets = benches
}

fn main() {
    spectra();
    Criterion::default().configure_from_args().final_summary();
}
