//! All systems of these tests as one type for each number of states.

use crate::attractors::systems::{
    Backwards, Detour, Driven, Leine, NearWells, Pushed, Rings, Shear, ToZero, Wells,
};
use crate::bifurcations::systems::{
    Area, AtParameter, Beat, BeatFamily, Belt, DenHartogFamily, Dragged, DrivenFamily,
    DrivenIsland, Ends, EndsFamily, FasterBelt, Focus, Grip, Island, Lags, Persists, Pitchfork,
    Pulse, Resonant, Rough, Shaken, Sheet, Softening, Twisted,
};
use crate::compiled::traced;
use crate::constant_fields::ConstantFields;
use crate::den_hartog::DenHartog;
use crate::smooth::{Lorenz, Smooth};

traced!(
    1:
    Beat, ConstantFields, NearWells,
);

traced!(
    2:
    Smooth<Backwards>, BeatFamily, DenHartog, Smooth<Detour>, AtParameter<Dragged>, Driven, Ends,
    AtParameter<Grip>, AtParameter<FasterBelt>, Leine, AtParameter<Persists>, Pushed,
    AtParameter<Rings>, Shaken, Smooth<Shear>, ToZero, AtParameter<Twisted>, Wells,
);

traced!(
    3:
    Belt, DenHartogFamily, DrivenIsland, Dragged, DrivenFamily, EndsFamily, Focus, Grip, FasterBelt,
    Island, AtParameter<Lags>, Smooth<Lorenz>, Persists, Pulse, Rings, Rough, AtParameter<Sheet>,
    Smooth<Softening>, Twisted,
);

traced!(
    4:
    Area, Lags, Resonant, Pitchfork, Sheet,
);
