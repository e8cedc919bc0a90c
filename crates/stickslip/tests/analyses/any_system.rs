//! All systems of these tests as one type for each number of states.

use stickslip::{Error, Filippov, Scalar, Side};

use crate::attractors::systems::{
    Backwards, Detour, Driven, Leine, NearWells, Pushed, Rings, Shear, ToZero, Wells,
};
use crate::bifurcations::systems::{
    Area, AtParameter, Beat, BeatFamily, Belt, Dragged, DrivenFamily, DrivenIsland, Ends, Focus,
    Grip, Held, Island, Lags, Persists, Pitchfork, Pulse, Resonant, Rough, Shaken, Sheet,
    Softening, Twisted,
};
use crate::den_hartog::DenHartog;
use crate::line::Line;
use crate::listed::{Listed, systems};
use crate::smooth::{Lorenz, Smooth};

systems!(Any1, 1: Beat(Beat), Line(Line), NearWells(NearWells));

systems!(
    Any2, 2:
    Backwards(Smooth<Backwards>), BeatFamily(BeatFamily), DenHartog(DenHartog), Detour(Smooth<Detour>), DraggedAt(AtParameter<Dragged>), Driven(Driven), Ends(Ends), GripAt(AtParameter<Grip>), Held(Held), Leine(Leine), PersistsAt(AtParameter<Persists>), Pushed(Pushed), RingsAt(AtParameter<Rings>), Shaken(Shaken), Shear(Smooth<Shear>), ToZero(ToZero), TwistedAt(AtParameter<Twisted>), Wells(Wells),
);

systems!(
    Any3, 3:
    Belt(Belt), DrivenIsland(DrivenIsland), Dragged(Dragged), DrivenFamily(DrivenFamily), Focus(Focus), Grip(Grip), Island(Island), LagsAt(AtParameter<Lags>), Lorenz(Smooth<Lorenz>), Pulse(Pulse), Rings(Rings), Rough(Rough), SheetAt(AtParameter<Sheet>), Softening(Smooth<Softening>), Twisted(Twisted),
);

systems!(Any4, 4: Area(Area), Lags(Lags), Resonant(Resonant), Pitchfork(Pitchfork), Sheet(Sheet));
