//! The page of speeds agrees with the committed table on `spectrum` and other packages.

use std::collections::BTreeMap;

const TABLE: &str = include_str!("../report/spectra.csv");
const PAGE: &str = include_str!("../docs/speed.md");
const OURS: &str = "spectrum";
/// With the delay and the dimension that the packages are given. Otherwise `spectrum` chooses them
/// itself.
const GIVEN: &str = "spectrum, embedding given";
/// Packages that give a spectrum.
const SPECTRA: [&str; 2] = ["nolds lyap_e", "neurokit2 eckmann1986"];
/// The fastest packages that give one exponent. The second one gets a straight part chosen in
/// advance.
const QUICK: [&str; 2] = [
    "neurokit2 makowski",
    "neurokit2 rosenstein1993, straight part",
];

struct Row {
    series: String,
    estimator: String,
    seconds: f64,
    error: f64,
    status: String,
}

fn rows() -> Vec<Row> {
    let mut reader = csv::Reader::from_reader(TABLE.as_bytes());
    let names = reader.headers().unwrap().clone();
    let read = |record: csv::StringRecord| {
        let cell = |wanted: &str| {
            let at = names.iter().position(|name| name == wanted).unwrap();
            record[at].to_owned()
        };
        Row {
            series: cell("series"),
            estimator: cell("estimator"),
            seconds: cell("seconds").parse().unwrap(),
            error: cell("error").parse().unwrap(),
            status: cell("status"),
        }
    };
    reader
        .records()
        .map(|record| read(record.unwrap()))
        .collect()
}

#[test]
fn the_page_says_what_the_table_holds() {
    let rows = rows();
    let mut by: BTreeMap<&str, BTreeMap<&str, &Row>> = BTreeMap::new();
    for row in &rows {
        by.entry(&row.estimator)
            .or_default()
            .insert(&row.series, row);
    }
    let ours = &by[OURS];
    let count = |holds: &dyn Fn(&str) -> bool| ours.keys().filter(|name| holds(name)).count();
    let smaller =
        |ours: &str, peer: &str| count(&|name| by[ours][name].error < by[peer][name].error);
    let peers = || by.keys().filter(|name| !name.starts_with(OURS));
    let others = peers().filter(|name| !SPECTRA.contains(name));
    let others: Vec<usize> = others.map(|peer| smaller(OURS, peer)).collect();
    let given: Vec<usize> = peers().map(|peer| smaller(GIVEN, peer)).collect();
    let mut faster: Vec<f64> = ours
        .keys()
        .map(|name| {
            let times = SPECTRA.map(|peer| by[peer][name].seconds);
            times[0].min(times[1]) / ours[name].seconds
        })
        .collect();
    faster.sort_by(f64::total_cmp);
    let series = ours.len();
    let quicker = QUICK.map(|peer| count(&|name| by[peer][name].seconds < ours[name].seconds));
    let message = format!(
        "The error of the first exponent is smaller than that of nolds `lyap_e` on {} series and \
         of neurokit2 `eckmann1986` on {}, the two that give a spectrum, and than those of the \
         others on {} to {}; with the embedding that the packages are given, than those of all on \
         {} to {}. The faster spectrum takes {:.0} times the time of the processor (median; {:.0} \
         to {:.0}), 20 times or more on {} of the {series}. neurokit2's `makowski`, which gives \
         one exponent, is faster than `spectrum` on {}, and its fit of a straight part that is \
         given on {}. On {} of the {series} `spectrum` itself calls its first exponent `starved`: \
         5000 values of one column are few.",
        smaller(OURS, SPECTRA[0]),
        smaller(OURS, SPECTRA[1]),
        others.iter().min().unwrap(),
        others.iter().max().unwrap(),
        given.iter().min().unwrap(),
        given.iter().max().unwrap(),
        0.5 * (faster[(series - 1) / 2] + faster[series / 2]),
        faster[0],
        faster[series - 1],
        faster.iter().filter(|&&times| times >= 20.0).count(),
        quicker[0],
        quicker[1],
        count(&|name| ours[name].status == "starved"),
    );
    let words = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(words(PAGE).contains(&words(&message)), "{message}");
}
