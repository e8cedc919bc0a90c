//! Shares of basins along a parameter, with attractors followed from value to value.

use std::mem::discriminant;
use std::ops::ControlFlow;

use super::{Basin, Share};
use crate::analysis::attractors::{Attractor, Attractors, RecurrenceSettings};
use crate::dynamics::{AsDynamics, Components, Vector};
use crate::error::Error;
use crate::filippov::Options;

/// The attractors at one value of a parameter, and the share of each.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SharesAt {
    /// The parameter.
    pub parameter: f64,
    /// Attractors and other outcomes, in the order in which starts first reach them. Attractors
    /// that only the orbit from an earlier value reaches follow.
    pub attractors: Vec<Attractor>,
    /// Band of each attractor. One that goes on from the value before has the same band there.
    pub bands: Vec<usize>,
    /// Number of starts that lead to each attractor.
    pub starts: Vec<usize>,
    /// Number of bands so far.
    pub known_bands: usize,
}

impl SharesAt {
    /// The share of an attractor, with its standard error for random starts.
    pub fn share(&self, number: usize) -> Share {
        Share::of(self.starts[number], self.starts.iter().sum())
    }
}

impl SharesAt {
    /// Shares of the basins at one value of a parameter. `before` has the system and the shares at
    /// a value nearby, with whose attractors the new ones are identified.
    ///
    /// An attractor goes on from one before if an orbit from the earlier attractor leads to it, and
    /// an orbit from it in the earlier system leads back. Where only one of the two holds, as near
    /// a fold, both must have the same motion: kind, phases, mode of an equilibrium. The rule has
    /// no distance to choose. It holds wherever the step of the parameter moves attractors by less
    /// than the size of their basins. Attractors.jl matches by one of these two orbits, or by
    /// distances in the state space. An attractor that no start reaches stays while the orbit from
    /// its last value reaches it.
    ///
    /// Outcomes that are no attractors, such as escape, have a band each, which they keep.
    ///
    /// The callback is called after each start and may stop the computation; the result is then
    /// `None`.
    ///
    /// Basin stability along a parameter is a standard of the field (Menck, Heitzig, Marwan &
    /// Kurths, *Nature Physics* 9 (2013) 89; Stender & Hoffmann, *Nonlinear Dynamics* 107 (2022)
    /// 1451, for `bSTAB`).
    ///
    /// ```
    #[doc = include_str!("../../../examples/common/belt.rs")]
    /// use std::ops::ControlFlow;
    /// use stickslip::analysis::{RecurrenceSettings, SharesAt};
    /// use stickslip::{Options, State};
    ///
    /// let [slow, fast] = [0.2, 0.3].map(|speed| Belt { speed });
    /// let starts = (0..10).map(|k| State::from([0.2 * f64::from(k), 0.0]));
    /// let how = (&RecurrenceSettings::within(500.0), &Options::default());
    /// let (none, go_on) = (None::<(&Belt, &SharesAt)>, || ControlFlow::Continue(()));
    /// let first = SharesAt::of(&slow, 0.2, starts.clone(), none, how, go_on)?.unwrap();
    /// let before = Some((&slow, &first));
    /// let next = SharesAt::of(&fast, 0.3, starts, before, how, go_on)?.unwrap();
    /// for (number, band) in next.bands.iter().enumerate() {
    ///     println!("band {band}, share {:.2}", next.share(number).part);
    /// }
    /// assert_eq!(first.bands[0], next.bands[0]);
    /// # Ok::<(), stickslip::Error>(())
    /// ```
    ///
    /// # Errors
    /// Those of [`super::basin()`].
    pub fn of<Kind>(
        system: &impl AsDynamics<Kind>,
        parameter: f64,
        starts: impl IntoIterator<Item = impl Components>,
        before: Option<(&impl AsDynamics<Kind>, &SharesAt)>,
        (settings, options): (&RecurrenceSettings, &Options),
        after_each: impl Fn() -> ControlFlow<()> + Sync,
    ) -> Result<Option<SharesAt>, Error> {
        let (found, reached) = Basin::found_while(system, starts, settings, options, after_each)?;
        let Some(reached) = reached.into_iter().collect::<Option<Vec<usize>>>() else {
            return Ok(None);
        };
        let mut distinct = Attractors::new(system, settings, options).knowing(found);
        let mut bands: Vec<Option<usize>> = vec![None; distinct.all().len()];
        let mut known_bands = 0;
        if let Some((earlier, before)) = before {
            known_bands = before.known_bands;
            let forward = led_to(system, &before.attractors, &mut distinct, settings, options)?;
            bands.resize(distinct.all().len(), None);
            let mut old = Attractors::new(earlier, settings, options);
            old = old.knowing(before.attractors.clone());
            let back = led_to(earlier, distinct.all(), &mut old, settings, options)?;
            let mut goes_on = vec![false; before.bands.len()];
            // Orbits that lead both ways come first.
            for is_mutual in [true, false] {
                for (number, old) in before.attractors.iter().enumerate() {
                    let next = distinct.all().iter().enumerate().position(|(next, new)| {
                        let leads = [forward[number] == Some(next), back[next] == Some(number)];
                        let is_same = match (old.kind.is_attractor(), is_mutual) {
                            (true, true) => leads == [true, true],
                            (true, false) => leads.contains(&true) && !old.is_changed_to(new),
                            (false, _) => discriminant(&old.kind) == discriminant(&new.kind),
                        };
                        is_same && bands[next].is_none()
                    });
                    if let Some(next) = next.filter(|_| !goes_on[number]) {
                        bands[next] = Some(before.bands[number]);
                        goes_on[number] = true;
                    }
                }
            }
        }
        let mut starts = vec![0; distinct.all().len()];
        for number in reached {
            starts[number] += 1;
        }
        let mut kept = (Vec::new(), Vec::new(), Vec::new());
        for ((attractor, band), starts) in distinct.into_vec().into_iter().zip(bands).zip(starts) {
            // What no start reaches counts only as the continuation of an attractor.
            if starts == 0 && band.is_none() {
                continue;
            }
            kept.0.push(attractor);
            kept.1.push(band.unwrap_or_else(|| {
                known_bands += 1;
                known_bands - 1
            }));
            kept.2.push(starts);
        }
        // Outcomes that are no attractors may come back at a later value.
        if let Some((_, before)) = before {
            for (outcome, band) in before.attractors.iter().zip(&before.bands) {
                if !outcome.kind.is_attractor() && !kept.1.contains(band) {
                    kept.0.push(outcome.clone());
                    kept.1.push(*band);
                    kept.2.push(0);
                }
            }
        }
        let (attractors, bands, starts) = kept;
        Ok(Some(SharesAt {
            parameter,
            attractors,
            bands,
            starts,
            known_bands,
        }))
    }
}

/// The number of the attractor to which the orbit from each of some attractors leads; `None` for
/// what is no attractor.
fn led_to<Kind>(
    system: &impl AsDynamics<Kind>,
    attractors: &[Attractor],
    distinct: &mut Attractors<'_>,
    settings: &RecurrenceSettings,
    options: &Options,
) -> Result<Vec<Option<usize>>, Error> {
    let each = attractors.iter().map(|one| {
        let from: Option<&Vector> = one.next_start(settings).filter(|_| one.kind.is_attractor());
        let Some(from) = from else {
            return Ok(None);
        };
        let reached = Attractor::of_any(system, from, settings, options)?;
        let is_attractor = reached.kind.is_attractor();
        Ok(is_attractor.then(|| distinct.number(reached)))
    });
    each.collect()
}
