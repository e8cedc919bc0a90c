//! Orbits side by side: series of the same shape are expanded together, one orbit to a lane.
//!
//! One orbit's series is a chain of operations that wait for each other. Several orbits have several chains, and the machine
//! works on all of them in the time of one. What follows an expansion is each orbit's own, as it is alone, and every lane has
//! the bits that it would have alone.

use super::TaylorStepper;
use crate::error::Error;
use crate::filippov::driver::{Summary, check};
use crate::filippov::ensemble::Start;
use crate::filippov::journey::{Journey, on_flow};
use crate::filippov::march::{PhaseEnd, Run};
use crate::filippov::observer::Observer;
use crate::filippov::options::Options;
use crate::ode::Timed;
use crate::system::Filippov;
use crate::taylor::series::Series;
use crate::taylor::tape::{Numbers, Tape};

/// Orbits that are expanded together.
const LANES: usize = 8;

/// Orbits under way at once: enough that some of them are nearly always alike.
const SEATS: usize = 32;

/// An orbit under way.
struct Seat<'a, S, O, const N: usize> {
    /// Its place among the starts.
    number: usize,
    system: &'a S,
    run: Run<'a, O>,
    journey: Journey<N>,
    stepper: TaylorStepper<N>,
}

impl<'a, S: Filippov<N>, O: Observer<N>, const N: usize> Seat<'a, S, O, N> {
    /// An orbit at its first series, or the end of one that has none.
    fn taken(
        number: usize,
        start: &'a Start<S, N>,
        observer: &'a mut O,
        t_end: f64,
        options: &'a Options,
        mut stepper: TaylorStepper<N>,
    ) -> Result<Result<Self, Summary<N>>, Error> {
        let system = &start.system;
        let at = Timed {
            t: start.t,
            x: start.x,
        };
        check(system, &at, t_end, options)?;
        let mut run = Run::new(options, observer, t_end);
        let journey = match Journey::begin(&mut run, system, at) {
            Ok(journey) => journey,
            Err(ended) => return Ok(Err(ended)),
        };
        stepper.forget();
        let mut seat = Seat {
            number,
            system,
            run,
            journey,
            stepper,
        };
        seat.begin_phase();
        Ok(match seat.go_on(None)? {
            None => Ok(seat),
            Some(ended) => Err(ended),
        })
    }

    fn begin_phase(&mut self) {
        let Journey {
            mode, at, orders, ..
        } = self.journey;
        on_flow!(self.journey, self.system, |flow| self.stepper.begin(
            &mut self.run,
            flow,
            mode,
            at,
            orders
        ));
    }

    /// Goes on to where the next series is needed, or to the end of the run.
    fn go_on(&mut self, mut end: Option<PhaseEnd<N>>) -> Result<Option<Summary<N>>, Error> {
        loop {
            if let Some(end) = end {
                if let Some(summary) = self.journey.turn(&mut self.run, self.system, end)? {
                    return Ok(Some(summary));
                }
                self.begin_phase();
            }
            end = on_flow!(self.journey, self.system, |flow| self
                .stepper
                .prepare(&mut self.run, flow));
            if end.is_none() {
                return Ok(None);
            }
        }
    }

    /// A step on the series that was expanded.
    fn step(&mut self) -> Result<Option<Summary<N>>, Error> {
        let end = on_flow!(self.journey, self.system, |flow| self
            .stepper
            .step(&mut self.run, flow)?);
        self.go_on(end)
    }
}

/// What the orbits of a thread share.
struct Bench {
    /// A tape of every shape that was met.
    shapes: Vec<Tape>,
    /// The seats that wait for a series, by the shape of their tapes.
    alike: Vec<Vec<usize>>,
    series: Series<LANES>,
    numbers: Numbers<LANES>,
}

impl Bench {
    /// Lets a seat wait for others of its shape.
    fn wait(&mut self, seat: usize, tape: &mut Tape) {
        let shape = match tape.shape {
            Some(shape) => shape,
            None => self.shape(tape),
        };
        tape.shape = Some(shape);
        self.alike[shape].push(seat);
    }

    fn shape(&mut self, tape: &Tape) -> usize {
        let known = self.shapes.iter().position(|shape| shape.is_alike(tape));
        known.unwrap_or_else(|| {
            self.shapes.push(tape.clone());
            self.alike.push(Vec::new());
            self.shapes.len() - 1
        })
    }

    /// Takes the seats that are expanded next: of the shape that most wait with.
    fn call(&mut self) -> Vec<usize> {
        match self.alike.iter_mut().max_by_key(|seats| seats.len()) {
            Some(seats) => seats.split_off(seats.len().saturating_sub(LANES)),
            None => Vec::new(),
        }
    }

    fn expand<S, O, const N: usize>(&mut self, seats: &mut [Seat<'_, S, O, N>], group: &[usize]) {
        if let [one] = *group {
            seats[one].stepper.expand();
            return;
        }
        // Lanes without an orbit do the first one's work again.
        let of = |lane: usize| &seats[*group.get(lane).unwrap_or(&group[0])].stepper;
        let steppers: [&TaylorStepper<N>; LANES] = std::array::from_fn(of);
        let ends = steppers.map(|stepper| stepper.phase.end);
        let scales = steppers.map(|stepper| stepper.phase.scale);
        let tapes = steppers.map(TaylorStepper::tape);
        let x: [[f64; LANES]; N] = std::array::from_fn(|i| ends.map(|end| end.x[i]));
        self.numbers.gather(tapes.map(|tape| &tape.numbers));
        self.series.fit(tapes[0]);
        let order = steppers[0].order;
        self.series.expand_all(
            tapes[0],
            &self.numbers,
            (&ends.map(|end| end.t), &x),
            &scales,
            order,
        );
        for (lane, &seat) in group.iter().enumerate() {
            seats[seat].stepper.take_lane(&self.series, lane);
        }
    }
}

/// Runs every start with its observer, as [`crate::run`] does by [`crate::Method::Taylor`]; the outcomes are in the order of
/// the starts.
pub(in crate::filippov) fn side_by_side<S: Filippov<N>, O: Observer<N>, const N: usize>(
    starts: &[Start<S, N>],
    observers: &mut [O],
    t_end: f64,
    options: &Options,
) -> Vec<Result<Summary<N>, Error>> {
    let mut outcomes: Vec<_> = starts.iter().map(|_| None).collect();
    let mut bench = Bench {
        shapes: Vec::new(),
        alike: Vec::new(),
        series: Series::new(),
        numbers: Numbers::default(),
    };
    let mut waiting = starts.iter().zip(observers).enumerate();
    // The next orbit that gets under way; one that ends at once has its outcome.
    let mut next = |outcomes: &mut [Option<_>], mut stepper: Option<TaylorStepper<N>>| {
        waiting.find_map(|(number, (start, observer))| {
            let stepper = stepper
                .take()
                .unwrap_or_else(|| TaylorStepper::new(options));
            match Seat::taken(number, start, observer, t_end, options, stepper) {
                Ok(Ok(seat)) => Some(seat),
                Ok(Err(summary)) => {
                    outcomes[number] = Some(Ok(summary));
                    None
                }
                Err(error) => {
                    outcomes[number] = Some(Err(error));
                    None
                }
            }
        })
    };
    let mut seats = Vec::with_capacity(SEATS);
    while seats.len() < SEATS
        && let Some(seat) = next(&mut outcomes, None)
    {
        seats.push(seat);
    }
    for (i, seat) in seats.iter_mut().enumerate() {
        bench.wait(i, seat.stepper.tape_mut());
    }
    loop {
        let group = bench.call();
        if group.is_empty() {
            break;
        }
        bench.expand(&mut seats, &group);
        for i in group {
            let outcome = match seats[i].step() {
                Ok(None) => None,
                Ok(Some(summary)) => Some(Ok(summary)),
                Err(error) => Some(Err(error)),
            };
            if outcome.is_some() {
                outcomes[seats[i].number] = outcome;
                // The room that the last orbit took is the next one's.
                let stepper = std::mem::replace(&mut seats[i].stepper, TaylorStepper::new(options));
                match next(&mut outcomes, Some(stepper)) {
                    Some(seat) => seats[i] = seat,
                    None => continue,
                }
            }
            bench.wait(i, seats[i].stepper.tape_mut());
        }
    }
    outcomes.into_iter().flatten().collect()
}
