//! One pass of the listing's loop (lines 28–79).

use super::defects::Defect;
use super::record::{Instant, Motion, Sample, Zone, ZoneEnd, ends};
use super::setup::Setup;
use crate::paper::stages::{in_time, in_velocity};
use stickslip::{Mode, Side, State, math};

/// A body beyond this many times the outermost tangent point has escaped. There the spring pushes
/// outward with a thousand times its force at that point.
const ESCAPE_FACTOR: f64 = 10.0;

/// Event of a pass, besides the motion of the state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Event {
    /// The body began to stick.
    Entry(Option<Zone>),
    /// Left the stick zone through an end.
    Exit(ZoneEnd),
    /// Passed the belt's speed without sticking, to this side.
    Crossing(Side),
}

/// The loop's variables.
pub(super) struct Machine<'a> {
    setup: &'a Setup,
    /// `x` of the listing: `(t, x1, x2)` in seconds, metres, metres per second.
    x: [f64; 3],
    /// `xso`: the forcing at the clock of `x`.
    xs: f64,
    /// `slip` and `aft` in one: `slip == 1` is stick; otherwise `aft` is the side.
    pub(super) mode: Mode,
    /// `k`: the zone entered last.
    pub(super) zone: Option<Zone>,
}

impl<'a> Machine<'a> {
    /// The state at the start (lines 9–27).
    pub(super) fn start(setup: &'a Setup) -> Self {
        let x = setup.start;
        let xs = setup.model.support(x[0]);
        let mut machine = Machine {
            setup,
            x,
            xs,
            mode: Mode::Slip(Side::Above),
            zone: Zone::holding(x[1], &setup.tangent_points, xs),
        };
        machine.mode = machine.starting_mode();
        machine
    }

    fn starting_mode(&self) -> Mode {
        let [_, x1, x2] = self.x;
        let speed = self.setup.model.belt_speed;
        let [t1, t2, t3, t4, ..] = self.setup.tangent_points;
        if x2 != speed {
            return slip_above(x2 >= speed);
        }
        match self.setup.defects.has(Defect::StartUpTest) {
            true if (t2..=t1).contains(&x1) || (t4..=t3).contains(&x1) => Mode::Stick,
            true => Mode::Slip(Side::Above),
            false if self.zone.is_some() => Mode::Stick,
            false => self.side_of_spring(),
        }
    }

    /// The side to which both fields point outside a zone, and the tangent one at a zone's end.
    fn side_of_spring(&self) -> Mode {
        slip_above(self.spring(self.x[1] - self.xs) > 0.0)
    }

    pub(super) fn instant(&self) -> Instant {
        Instant {
            t: self.x[0],
            x1: self.x[1],
        }
    }

    pub(super) fn sample(&self, step: u64, in_window: bool) -> Sample {
        let [t, x1, x2] = self.x;
        Sample {
            step,
            t,
            x1,
            x2,
            mode: self.mode,
            in_window,
        }
    }

    /// Breakdown of the run, if the state is no longer a motion of the oscillator. `t` is the time
    /// before the last pass.
    pub(super) fn breakdown(&self, t: f64) -> Option<Motion> {
        let outermost = self.setup.tangent_points[0];
        if self.x.iter().any(|v| !v.is_finite()) {
            Some(Motion::BrokenDown { t })
        } else if (self.x[1] - self.xs).abs() > ESCAPE_FACTOR * outermost {
            Some(Motion::Escaped { t })
        } else {
            None
        }
    }

    /// One pass: moves the state and returns the event.
    pub(super) fn advance(&mut self) -> Option<Event> {
        match self.mode {
            Mode::Stick => self.stick(),
            Mode::Slip(side) => self.slip(side),
        }
    }

    fn move_to(&mut self, x: [f64; 3]) {
        self.x = x;
        self.xs = self.setup.model.support(x[0]);
    }

    /// Lines 30–45.
    fn stick(&mut self) -> Option<Event> {
        let setup = self.setup;
        let start = self.x;
        let moved = [start[0] + setup.h, start[1] + setup.h * start[2], start[2]];
        let xs = setup.model.support(moved[0]);
        let (upper, lower) = ends(self.zone, &setup.tangent_points);
        let through_lower = !setup.defects.has(Defect::OneSidedExit) && moved[1] <= lower + xs;
        // The comparison is false for NaN, so such a state leaves, as in the listing.
        let stays = moved[1] < upper + xs && !through_lower;
        if stays {
            self.move_to(moved);
            return None;
        }
        let (end, zone_end) = if through_lower {
            (ZoneEnd::Lower, lower)
        } else {
            (ZoneEnd::Upper, upper)
        };
        self.move_to(self.stick_exit(start, moved, zone_end, xs));
        self.mode = match setup.defects.has(Defect::ReversedExitSide) {
            true => slip_above(self.zone == Some(Zone::Middle)),
            false => self.side_of_spring(),
        };
        Some(Event::Exit(end))
    }

    /// The state where a stick phase ends at the zone's end `end`, given without forcing (lines
    /// 37–38).
    fn stick_exit(&self, start: [f64; 3], moved: [f64; 3], zone_end: f64, xs: f64) -> [f64; 3] {
        let defects = &self.setup.defects;
        if defects.has(Defect::InPlaceStages) {
            // Line 37 has overwritten x[1] before it subtracts it. So line 38 adds nothing to the
            // clock.
            return [moved[0], zone_end + xs, moved[2]];
        }
        if defects.has(Defect::FrozenForcing) {
            let x1 = zone_end + xs;
            return [start[0] + (x1 - start[1]) / start[2], x1, start[2]];
        }
        let gap_start = start[1] - zone_end - self.xs;
        let gap_end = moved[1] - zone_end - xs;
        // The gaps have the same sign only if the phase began outside its zone. Then it ends at
        // once.
        let fraction = if gap_start * gap_end < 0.0 {
            gap_start / (gap_start - gap_end)
        } else {
            0.0
        };
        let wait = fraction * self.setup.h;
        [start[0] + wait, start[1] + wait * start[2], start[2]]
    }

    /// Lines 47–78.
    fn slip(&mut self, side: Side) -> Option<Event> {
        let setup = self.setup;
        let speed = setup.model.belt_speed;
        let start = self.x;
        let moved = self.slip_step(side, start);
        let crossed = (moved[2] - speed) * side.sign() <= 0.0;
        if !crossed {
            self.move_to([start[0] + setup.h, moved[1], moved[2]]);
            return None;
        }
        // As printed, the state before the step is overwritten.
        let origin = if setup.defects.has(Defect::InPlaceStages) {
            moved
        } else {
            start
        };
        let landed = self.henon_step(side, origin);
        self.move_to([landed[0], landed[1], speed]);
        Some(self.arrive(side))
    }

    /// `x2'` in metres per second squared (lines 83–84). The friction is `μ0/(pole − x2)`. The pole
    /// is `vp + 1` below the belt's speed and `vp − 1` above it (line 25).
    fn acceleration(&self, side: Side, t: f64, x: &State<2>) -> f64 {
        let model = &self.setup.model;
        let xs = match self.setup.defects.has(Defect::FrozenForcing) {
            true => self.xs,
            false => model.support(t),
        };
        let pole = model.belt_speed - side.sign();
        (1.0 / model.mass) * (self.spring(x[0] - xs) + model.mu0 / (pole - x[1]))
    }

    /// Spring force `s = k2 z³ − k1 z` in newtons at the stretch `z` in metres (lines 53, 69).
    ///
    /// The cube is a power, as in the listing: a product rounds differently.
    fn spring(&self, z: f64) -> f64 {
        let model = &self.setup.model;
        -model.k1 * z + model.k2 * math::pow(z, 3.0)
    }

    /// The caller's loop sets the clock (lines 60 and 76).
    fn slip_step(&self, side: Side, [t, x1, x2]: [f64; 3]) -> [f64; 3] {
        let in_place = self.setup.defects.has(Defect::InPlaceStages);
        let field = |t, x: &State<2>| State::from([x[1], self.acceleration(side, t, x)]);
        let start = (t, State::from([x1, x2]));
        let end = in_time(in_place, self.setup.h, start, field);
        [t, end[0], end[1]]
    }

    fn henon_step(&self, side: Side, [t, x1, x2]: [f64; 3]) -> [f64; 3] {
        let defects = &self.setup.defects;
        let speed = self.setup.model.belt_speed;
        let h = if side == Side::Above && defects.has(Defect::S2StepSign) {
            x2 - speed
        } else {
            speed - x2
        };
        let sixth = if defects.has(Defect::SixthRounded) {
            h * 0.166666
        } else {
            h / 6.0
        };
        let in_place = defects.has(Defect::InPlaceStages);
        let slope = |t, x: &State<2>| {
            let per_velocity = 1.0 / self.acceleration(side, t, x);
            (per_velocity, State::from([x[1] * per_velocity, 1.0]))
        };
        let start = (t, State::from([x1, x2]));
        let (t, end) = in_velocity(in_place, (h, sixth), start, slope);
        [t, end[0], end[1]]
    }

    /// Stick or cross, by the transition function of Eq. (19) (lines 53–58).
    fn arrive(&mut self, side: Side) -> Event {
        let model = &self.setup.model;
        let inverse_mass = 1.0 / model.mass;
        let s = self.spring(self.x[1] - self.xs);
        let sigma = 1.0 / (inverse_mass * inverse_mass) * (s * s - model.mu0 * model.mu0);
        if sigma <= 0.0 {
            self.zone = Zone::holding(self.x[1], &self.setup.tangent_points, self.xs);
            self.mode = Mode::Stick;
            return Event::Entry(self.zone);
        }
        self.mode = Mode::Slip(side.opposite());
        Event::Crossing(side.opposite())
    }
}

fn slip_above(above: bool) -> Mode {
    Mode::Slip(if above { Side::Above } else { Side::Below })
}
