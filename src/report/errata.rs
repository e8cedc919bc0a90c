//! The paper's misprints, each with the computation that shows it.

use super::accuracy::Accuracy;
use super::matrix::{Matrix, MatrixError};
use crate::figures::rows::{Row, Value};
use crate::paper::listing::{Defect, Defects, ListingError, Mode, Params, Setup, run, run_with};
use crate::paper::published::{PublishedError, published};
use stickslip::analysis::data_spectrum::{DataError, DataSettings, Series, data_spectrum};
use stickslip::error::Error;
use stickslip::filippov::{Fate, Options, fate, solve};
use stickslip::models::cubic::Cubic;
use stickslip::models::{BeltOscillator, Caption, ForcedOscillator, Rig};
use stickslip::system::{Filippov, Side, State};

/// A number that shows a misprint.
#[derive(Clone, Debug, PartialEq)]
pub struct Shown {
    /// What it is.
    pub what: String,
    /// Its value.
    pub value: f64,
    /// Its unit.
    pub unit: &'static str,
}

/// A misprint or defect.
#[derive(Clone, Debug, PartialEq)]
pub struct Erratum {
    /// Where.
    pub place: String,
    /// What stands there, in our words.
    pub printed: String,
    /// What should.
    pub correct: String,
    /// The computation's results.
    pub shown: Vec<Shown>,
    /// Whether they bear it out.
    pub holds: bool,
}

/// Why the errata could not be computed.
#[derive(Debug, thiserror::Error)]
pub enum ErrataError {
    /// The solver failed.
    #[error(transparent)]
    Solver(#[from] Error),
    /// The listing cannot run.
    #[error(transparent)]
    Listing(#[from] ListingError),
    /// The estimator failed.
    #[error(transparent)]
    Data(#[from] DataError),
    /// The table of claims lacks a number.
    #[error(transparent)]
    Published(#[from] PublishedError),
    /// A run of the listing could not be compared.
    #[error(transparent)]
    Matrix(#[from] MatrixError),
}

fn shown(what: impl Into<String>, value: f64, unit: &'static str) -> Shown {
    let what = what.into();
    Shown { what, value, unit }
}

fn erratum(place: &str, printed: &str, correct: &str, shown: Vec<Shown>, holds: bool) -> Erratum {
    Erratum {
        place: place.to_owned(),
        printed: printed.to_owned(),
        correct: correct.to_owned(),
        shown,
        holds,
    }
}

/// All of them, in the order of the paper. `rows` are those of Figs. 10–12.
///
/// # Errors
/// [`ErrataError`].
pub fn errata(
    matrix: &Matrix,
    accuracy: &Accuracy,
    rows: &[&Row],
) -> Result<Vec<Erratum>, ErrataError> {
    let mut all = vec![
        unit_of_mu0()?,
        step_from_above(accuracy),
        time_in_stick()?,
        sign_of_friction()?,
        spring_signs(),
        lengths_and_durations()?,
        start_of_fig08()?,
        regions_of_arcs()?,
        direction_of_oscillation()?,
        shift_in_estimator()?,
        signs_of_bracket(rows),
        friction_counted_twice()?,
        order_of_captions(),
        caption_of_fig10(),
    ];
    all.extend(listing_defects(matrix)?);
    Ok(all)
}

/// Sect. 2: a coefficient would not scale with the spring.
fn unit_of_mu0() -> Result<Erratum, Error> {
    let soft = Cubic::new(1.0, 1.0)?.critical_mu0()[1];
    let stiff = Cubic::new(2.0, 2.0)?.critical_mu0()[1];
    Ok(erratum(
        "Eq. (2), (13)",
        "mu0 is called a coefficient of static friction, although the normal force mg has been left out of T",
        "mu0 is a force in newtons; the coefficient is mu0/(mg)",
        vec![
            shown("critical mu0 for k1 = k2 = 1", soft, "N"),
            shown("critical mu0 for k1 = k2 = 2", stiff, "N"),
            shown(
                "their ratio, 1 if mu0 were a pure number",
                stiff / soft,
                "1",
            ),
        ],
        (stiff / soft - 2.0).abs() < 1e-12,
    ))
}

fn step_from_above(accuracy: &Accuracy) -> Erratum {
    let printed = accuracy.printed_sign.at_printed_step;
    let [_, stated] = &accuracy.stated;
    erratum(
        "Sect. 3 and listing line 66",
        "coming from x2 > vp the Hénon step in velocity is x2 - vp",
        "vp - x2 from either side",
        vec![
            shown(
                "event time off at h = 1e-4 s, sign as printed",
                printed,
                "s",
            ),
            shown(
                "event time off at h = 1e-4 s, sign mended",
                stated.at_printed_step,
                "s",
            ),
        ],
        // The wrong sign costs about the length of a step, the right one rounding.
        printed > 1e-5 && stated.at_printed_step < 1e-9,
    )
}

/// Eq. (15) takes an acceleration for a velocity: on the belt it is one at which the field vanishes.
fn time_in_stick() -> Result<Erratum, Error> {
    let model = ForcedOscillator::default();
    let start = State::from([0.0, model.belt_speed]);
    let orbit = solve(&model, 0.0, start, model.period(), &Options::tol(1e-13))?;
    let stick = orbit.sticks().next().ok_or(Error::NotFound {
        what: "a stick phase",
        t: 0.0,
        span: model.period(),
    })?;
    let per_length = stick.duration() / stick.displacement()[0];
    let acceleration = |side| model.field(side, stick.t_end, &stick.x_end)[1].abs();
    let least = acceleration(Side::Below).min(acceleration(Side::Above));
    Ok(erratum(
        "Eq. (15)",
        "in a stick phase dt/dx1 is 1/f2",
        "1/x2 = 1/vp, as in the listing",
        vec![
            shown("duration over length of a stick phase", per_length, "s/m"),
            shown("1/vp", 1.0 / model.belt_speed, "s/m"),
            shown(
                "|f2| at the tangent point where the step ends",
                least,
                "m/s²",
            ),
        ],
        (per_length * model.belt_speed - 1.0).abs() < 1e-9 && least < 1e-9,
    ))
}

fn sign_of_friction() -> Result<Erratum, Error> {
    let model = ForcedOscillator::default().checked()?;
    let printed = ForcedOscillator {
        mu0: -model.mu0,
        ..model
    };
    let x = State::from([0.0, model.belt_speed]);
    let [below, above] = [Side::Below, Side::Above].map(|side| printed.field(side, 0.0, &x)[1]);
    let repels = fate(&printed, 0.0, &x) == Fate::Repelling;
    let sticks = fate(&model, 0.0, &x) == Fate::Stick;
    Ok(erratum(
        "Eq. (17)",
        "friction enters with +T(v)",
        "-T(v), as in Eq. (4), Eq. (18) and the listing",
        vec![
            shown(
                "with +T, acceleration just below the belt's speed, mid-zone",
                below,
                "m/s²",
            ),
            shown(
                "with +T, just above it: both lead away, so nothing can stick",
                above,
                "m/s²",
            ),
        ],
        repels && sticks,
    ))
}

fn spring_signs() -> Erratum {
    let first = BeltOscillator::default();
    let second = ForcedOscillator {
        mass: first.mass,
        ..ForcedOscillator::default()
    };
    let (mut difference, mut sum, mut sigma) = (0.0_f64, 0.0_f64, 0.0_f64);
    for k in -150..=150 {
        let z = f64::from(k) / 100.0;
        // Friction is the same on either side of Σ but for its sign, so that the mean is the spring's.
        let of = |below: f64, above: f64| (0.5 * (below + above), below * above);
        let x = State::from([z, first.belt_speed]);
        let on = |side| first.field(side, 0.0, &x)[1];
        let one = of(on(Side::Below), on(Side::Above));
        let x = State::from([z, second.belt_speed]);
        let on = |side| second.field(side, 0.0, &x)[1];
        let other = of(on(Side::Below), on(Side::Above));
        difference = difference.max((one.0 - other.0).abs());
        sum = sum.max((one.0 + other.0).abs());
        sigma = sigma.max((one.1 - other.1).abs());
    }
    erratum(
        "Eq. (1) against Eq. (17)",
        "the springs of the two models have opposite signs, without a word: a double well in the first, a softening spring that \
         lets bodies escape in the second",
        "sigma, the only function both share, cannot tell them apart; the dynamics can",
        vec![
            shown(
                "largest difference of the springs' accelerations, |z| <= 1.5",
                difference,
                "m/s²",
            ),
            shown("largest sum of them", sum, "m/s²"),
            shown("largest difference of sigma", sigma, "m²/s⁴"),
        ],
        difference > 0.1 && sum < 1e-14 && sigma < 1e-14,
    )
}

fn lengths_and_durations() -> Result<Erratum, ErrataError> {
    let value = |id: &str| Ok::<f64, PublishedError>(published(id)?.values().into_iter().sum());
    let belt = ForcedOscillator::default().belt_speed;
    let mut rows = Vec::new();
    let mut least = f64::INFINITY;
    for k in [1, 2] {
        let length = value(&format!("fig08.stick_length.{k}"))?;
        let duration = value(&format!("fig08.stick_duration.{k}"))?;
        let excess = duration - length / belt;
        least = least.min(excess);
        rows.push(shown(
            format!("published duration {k} less length {k}/vp"),
            excess,
            "s",
        ));
    }
    // Half a unit of the last printed digit in either number.
    let rounding = 0.5e-4 + 0.5e-4 / belt;
    rows.push(shown(
        "largest difference that rounding explains",
        rounding,
        "s",
    ));
    Ok(erratum(
        "Sect. 4.2",
        "the stick phases' durations are longer than their lengths over the belt's speed",
        "equal: the body rides the belt",
        rows,
        least > rounding,
    ))
}

fn start_of_fig08() -> Result<Erratum, ErrataError> {
    let listed = Params::default();
    let captioned = Params {
        x1: listed.tangent_points[2],
        ..listed
    };
    let mut rows = vec![
        shown("x1 at the start by the caption", captioned.x1, "m"),
        shown("x1 at the start by the listing", listed.x1, "m"),
    ];
    let mut both_agree = true;
    let claims = super::matrix::four_claims()?;
    for (name, params) in [("caption", captioned), ("listing", listed)] {
        let setup = Setup {
            params,
            ..Setup::default()
        };
        let numbers = run(&setup)?.four_numbers().unwrap_or([f64::NAN; 4]);
        both_agree &= claims.iter().zip(numbers).all(|(claim, v)| claim.agrees(v));
        rows.push(shown(
            format!("first stick length from the {name}'s start"),
            numbers[0],
            "m",
        ));
    }
    rows.push(shown(
        "starts that give all four numbers, of 2",
        1.0 + f64::from(u8::from(both_agree)),
        "1",
    ));
    Ok(erratum(
        "Fig. 8 caption",
        "the start is the third tangent point",
        "the listing starts from T[3], the fourth",
        rows,
        captioned.x1 != listed.x1,
    ))
}

fn regions_of_arcs() -> Result<Erratum, ErrataError> {
    let belt = Params::default().belt_speed;
    let (mut highest_below, mut lowest_above) = (f64::NEG_INFINITY, f64::INFINITY);
    run_with(&Setup::default(), |sample| match sample.mode {
        Mode::Below if sample.in_window && sample.x2 != belt => {
            highest_below = highest_below.max(sample.x2);
        }
        Mode::Above if sample.in_window && sample.x2 != belt => {
            lowest_above = lowest_above.min(sample.x2);
        }
        _ => {}
    })?;
    Ok(erratum(
        "Sect. 4.2",
        "S1 holds the upper arcs of the trajectory and S2 the lower ones",
        "S1 = {x2 < vp} holds the lower ones, S2 the upper",
        vec![
            shown(
                "largest velocity in S1 over the plotted window",
                highest_below,
                "m/s",
            ),
            shown("least velocity in S2", lowest_above, "m/s"),
        ],
        highest_below < belt && lowest_above > belt,
    ))
}

fn direction_of_oscillation() -> Result<Erratum, Error> {
    let model = ForcedOscillator::default();
    let quarter = 0.25 * model.period();
    let [up, down] = [quarter, 3.0 * quarter].map(|t| model.tangent_points(t));
    let (up, down) = (up?, down?);
    let travel = match (up.first(), down.first()) {
        (Some(up), Some(down)) => up.position - down.position,
        _ => f64::NAN,
    };
    Ok(erratum(
        "Sect. 4.2",
        "the stick zone oscillates along x2",
        "along x1: on the discontinuity zone x2 is always vp",
        vec![
            shown("travel of a tangent point in x1", travel, "m"),
            shown("twice the amplitude A", 2.0 * model.amplitude, "m"),
        ],
        (travel - 2.0 * model.amplitude).abs() < 1e-12,
    ))
}

/// On the logistic map, whose exponent is ln 2, with a shift of two for one interval.
fn shift_in_estimator() -> Result<Erratum, ErrataError> {
    let mut x = 0.3;
    let rows: Vec<[f64; 1]> = (0..4000)
        .map(|_| {
            x = 4.0 * x * (1.0 - x);
            [x]
        })
        .collect();
    let series = Series::from_rows(rows, 1.0)?;
    let with = |step| {
        let settings = DataSettings {
            step,
            ..DataSettings::default()
        };
        let spectrum = data_spectrum(&series, &settings)?;
        let first = spectrum.exponents.first().map(|e| e.value);
        Ok::<f64, DataError>(first.unwrap_or(f64::NAN))
    };
    let (one, two) = (with(1)?, with(2)?);
    let truth = stickslip::math::ln(2.0);
    Ok(erratum(
        "Eq. (25)",
        "the neighbours are taken m steps on, the reference point d steps",
        "both d: m is defined nowhere, and with another shift than that in tau = d t every exponent is wrong by their ratio",
        vec![
            shown("exponent of the logistic map, shift 1", one, "1"),
            shown("shift 2, tau of two steps", two, "1"),
            shown("shift 2, tau of one step", 2.0 * two, "1"),
            shown("ln 2", truth, "1"),
        ],
        (one - truth).abs() < 0.02 && (two - truth).abs() < 0.02,
    ))
}

fn signs_of_bracket(rows: &[&Row]) -> Erratum {
    let mut found = Vec::new();
    for figure in ["fig10", "fig11", "fig12"] {
        let id = format!("{figure}.diverges_at");
        let row = rows
            .iter()
            .find(|row| row.id == id && row.reading == "as-printed");
        if let Some(Value::Number(t)) = row.map(|row| &row.value) {
            found.push(shown(
                format!("a component passes 1000, {figure}, at t"),
                *t,
                "t",
            ));
        }
    }
    let holds = found.len() == 3;
    erratum(
        "Eq. (27)",
        "in the second row x3 and T(v) enter the bracket with a minus sign",
        "with a plus sign: the spring between block and bracket is stretched by x1 + x3, and friction opposes slip",
        found,
        holds,
    )
}

/// The normal force by Newton's law, in units of mg, and the two ways to write it with ξ6.
fn friction_counted_twice() -> Result<Erratum, Error> {
    let rig = Rig {
        mass: 1.0,
        inertia: 0.5,
        arm: 0.3,
        k1: 2.0,
        k2: 1.0,
        k3: 0.9,
        c1: 0.0,
        c2: 0.0,
        gravity: 9.81,
        mu0: 0.7,
        delta: 1.0,
        belt_speed: 0.2,
    }
    .checked()?;
    let state = State::from([0.0, 0.0, 2.0, 0.0]);
    let newton = rig.unclipped_normal_force(&state) / (rig.mass * rig.gravity);
    let x3 = state[2] / rig.length_unit();
    let xi6 = rig.mu0 * rig.k3 / rig.k2;
    let (plain, over) = (1.0 - xi6 * x3, 1.0 - xi6 * x3 / rig.mu0);
    Ok(erratum(
        "Eq. (28)",
        "friction is mu0 (1 - xi6 x3 - xi7 x4), although xi6 and xi7 hold a factor mu0 already",
        "mu0 - xi6 x3 - xi7 x4",
        vec![
            shown("normal force over mg of a rig in SI units", newton, "1"),
            shown("by Eq. (28) as printed", plain, "1"),
            shown("by the corrected form", over, "1"),
        ],
        (over - newton).abs() < 1e-12 && (plain - newton).abs() > 1e-3,
    ))
}

fn order_of_captions() -> Erratum {
    let mut rows = Vec::new();
    let mut holds = true;
    for (figure, caption) in [("Fig. 11", Caption::FIG11), ("Fig. 12", Caption::FIG12)] {
        let [_, xi2, _, xi4, xi5, sixth, seventh, ..] = caption.numbers;
        rows.push(shown(
            format!("{figure}: seventh number over sixth"),
            seventh / sixth,
            "1",
        ));
        rows.push(shown(format!("{figure}: xi4 - 1 = k3/k2"), xi4 - 1.0, "1"));
        holds &= (seventh / sixth - (xi4 - 1.0)).abs() < 1e-3 && xi2 == 0.0 && xi5 == 0.0;
    }
    erratum(
        "Captions of Figs. 10-12",
        "the nine numbers are headed xi1 … xi7, delta, vp",
        "they are xi1 … xi5, mu0, xi6, delta, vp: xi2 = xi5 = 0 leaves no damper and so xi7 = 0, and the seventh over the sixth is \
         xi6/mu0 = k3/k2",
        rows,
        holds,
    )
}

fn caption_of_fig10() -> Erratum {
    let [_, _, _, xi4, _, mu0, xi6, ..] = Caption::FIG10.numbers;
    erratum(
        "Caption of Fig. 10",
        "the seventh number is 1.115",
        "another number there, or at xi4 or mu0: the relation that holds for Figs. 11 and 12 fails",
        vec![
            shown("seventh number over sixth", xi6 / mu0, "1"),
            shown("xi4 - 1", xi4 - 1.0, "1"),
            shown(
                "seventh number that the two others ask for",
                mu0 * (xi4 - 1.0),
                "1",
            ),
        ],
        (xi6 / mu0 - (xi4 - 1.0)).abs() > 1e-2,
    )
}

/// What changes when a defect alone is mended; the test of the start changes something for another start only.
fn listing_defects(matrix: &Matrix) -> Result<Vec<Erratum>, ErrataError> {
    let printed = matrix.all();
    let mut all = Vec::new();
    for defect in Defect::ALL {
        let mended = matrix.mended(defect);
        let mut rows = Vec::new();
        let mut holds = mended.motion != printed.motion;
        match (mended.numbers, printed.numbers) {
            (Some(mended), Some(printed)) => {
                let change = |i: usize| mended[i] - printed[i];
                holds |= (0..4).any(|i| change(i) != 0.0);
                rows.push(shown(
                    "mended alone, first stick length changes by",
                    change(0),
                    "m",
                ));
                rows.push(shown("second stick length by", change(1), "m"));
            }
            _ => rows.push(shown(
                "stick phases left when mended alone",
                mended.numbers.map_or(0.0, |_| 2.0),
                "1",
            )),
        }
        if defect == Defect::StartUpTest {
            let sticks = [Defects::AS_PRINTED, Defects::AS_PRINTED.flipped(defect)]
                .map(sticks_from_lower_zone);
            let [as_printed, mended] = sticks;
            let (as_printed, mended) = (as_printed?, mended?);
            let number = |sticks: bool| f64::from(u8::from(sticks));
            rows.push(shown(
                "sticks from a start in the lower zone, printed",
                number(as_printed),
                "1",
            ));
            rows.push(shown("the same, mended", number(mended), "1"));
            holds = !as_printed && mended;
        }
        all.push(Erratum {
            place: format!("Listing, lines {}", defect.lines()),
            printed: defect.description().to_owned(),
            correct: instead_of(defect).to_owned(),
            shown: rows,
            holds,
        });
    }
    Ok(all)
}

/// What the listing should do instead.
fn instead_of(defect: Defect) -> &'static str {
    match defect {
        Defect::InPlaceStages => {
            "a copy of the state, so that a step moves it by h and a crossing step can be taken back"
        }
        Defect::FrozenForcing => "each stage at its own time",
        Defect::OneSidedExit => "both ends: the lower one can overtake the body",
        Defect::ReversedExitSide => "the side that the spring force leads to",
        Defect::S2StepSign => "a - x[2] on both sides",
        Defect::StartUpTest => "all three zones, moved by the forcing at the start",
        Defect::SixthRounded => "1/6",
    }
}

/// Whether a body on the belt in the middle of the lower stick zone sticks at once.
fn sticks_from_lower_zone(defects: Defects) -> Result<bool, ListingError> {
    let tangent = Params::default().tangent_points;
    let params = Params {
        x1: tangent[4].midpoint(tangent[5]),
        ..Params::default()
    };
    let outcome = run(&Setup {
        params,
        defects,
        end: 0.01,
        window_start: 0.0,
        ..Setup::default()
    })?;
    let first = outcome.phases.first().map(|phase| phase.entry);
    let entry = first.or(outcome.unfinished.map(|(entry, _)| entry));
    Ok(entry.is_some_and(|entry| entry.t == 0.0))
}
