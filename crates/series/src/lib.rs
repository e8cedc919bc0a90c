//! Lyapunov spectrum of a series of states, without the equations: Sano and Sawada, Phys. Rev.
//! Lett. 55, 1082 (1985); Eckmann, Oseledets, Ruelle and Ciliberto, Phys. Rev. A 34, 4971 (1986);
//! Eqs. (25) and (26) of the paper.
//!
//! 1. Every point's neighbours are found, and the linear map that takes them to where they are a step later, by
//!    least squares through an orthogonal decomposition of the neighbour matrix.
//! 2. The maps are chained, `x_j → x_{j+d} → …`, on orthonormal vectors. An exponent is the mean logarithm of the stretching in
//!    its position.
//! 3. It is measured which directions the series has points in. An attractor of dimension m in n columns determines
//!    m exponents; for the others the least squares fit curvature or rounding, and the outcome, though it
//!    looks like any other, depends on eps and on how small singular values are treated. These are
//!    [`Status::Unidentified`].
//!
//! 4. The same is done with quadratic maps from neighbourhoods of two sizes, and the exponents are extrapolated to size zero
//!    ([`Estimator::Extrapolated`], the default). What the extrapolation does to an exponent is counted into its error; one of which too much
//!    is extrapolated is [`Status::Unstable`].
//! 5. It is measured how much of the neighbours' motion the maps predict. Noise, and a single column of a system of more
//!    dimensions, give exponents, too; these are [`Status::Unpredictable`].
//!
//! Points 1 and 2 alone are [`Estimator::SanoSawada`] ([`DataSettings::sano_sawada`]), the
//! estimator of the paper's Figs. 10 to 12. Its value comes along with the other
//! ([`DataExponent::sano_sawada`]). There the chain is run a second time with maps from
//! neighbourhoods of twice the size, and an exponent that changes by much more than its standard
//! error is [`Status::Unstable`].
//!
//! # What is extrapolated
//! Maps are fitted as `y' = A y + Q(u, u)`, with a quadratic form of the widest directions for each component (at most 28 unknowns, so that
//! there are forms of all directions up to six columns), to three neighbours for each unknown and to twice as many. The forms take the
//! curvature of the attractor for what it is; directions that are not tangent and of which the forms leave next to nothing are
//! left out. Series too short for that (the larger neighbourhood would hold more than a twentieth of them) get linear maps of
//! the neighbours asked for and twice as many. Where linear ones are asked for in a longer series, what quadratic ones give stands in
//! their error. [`DataSettings::neighbours`] is the fewest in any case.
//!
//! # What "ok" promises
//! The true exponent is within two standard errors in nine of ten cases or more. That was counted on 200 series of eight systems of
//! known spectrum, 5000 to 100000 points without noise, with lengths and starts that no constant was chosen on, on these with noise of a
//! thousandth of their spread, and on their first columns alone, embedded, of both of which fewer exponents are called so: the tables are in
//! `examples/spectrum_coverage/README.md`. Of whole states it is as much from 30 reference points ([`DataSettings::references`]) that reach over two
//! Theiler windows or more, and less from a shorter piece of an orbit. It is no promise for data with noise of another kind, for series that do not go through the
//! attractor many times, and for systems with corners at points that few orbits visit.
//!
//! # The divergence
//! The exponents of all directions add up to the mean divergence of the system. Where it is known,
//! [`DataSpectrum::balance`] holds the sum against it, or says what the exponents that the data do not tell must be: Lorenz' third, of
//! which no series shows anything, comes out as −14.57 that way.
//!
//! # The columns are not standardised
//! Distances are taken in the columns as they are, so that the same factor for all columns, or another order of them,
//! changes nothing, but a factor for one column does: a ball becomes an ellipsoid, other points are neighbours, and the
//! estimate moves within its error, bias included. A column a thousand times larger than the others decides alone who is a neighbour;
//! bring columns to comparable units first.
//!
//! # The bias of Sano and Sawada's estimator
//! Neighbourhoods are finite, and the second-order terms that a linear map leaves out act like a perturbation of it. They
//! bias exponents by an amount that shrinks with the radius and that the standard error, which is statistical only, does not
//! contain: for the Lorenz system at 45001 points 0.9056 and 0 come out as about 0.87 and 0.03, with either fit, and
//! `eps_sensitivity` says −0.03 and 0.03. A longer step helps flows (0.88 and 0.02 at `d = 5`). They hide contractions: over `d` steps nothing shrinks
//! below about the relative radius, and a strongly negative exponent rises with `d` (Hénon's second from −1.6 to −1.1 at
//! `d = 4`). Doubling the neighbourhoods does not reveal every bias: Fig. 12's second exponent, 0, comes out as 0.005 ± 0.001
//! and hardly moves. The fit of fixed rank has little bias for directions on a smooth curve or torus with neighbourhoods small against
//! its bends; where the orbit has corners, as on Fig. 11's torus with stick, it is off by many standard errors, and on a fractal it
//! counts what it cuts off as loss.
//!
//! # Fewer columns than the system has
//! One measured column is no state. [`choose_embedding`] makes one of delayed values: the delay is the first minimum of the average mutual
//! information (of values on a curve, as of a sine, which has none, the first zero of the autocorrelation), the number of values the first at which false nearest neighbours are gone, with Cao's averages beside it;
//! [`Embedding::of`] is the series of these vectors. Maps of such vectors know all but the last values already, and each brings its noise:
//! affine maps over a delay from some 40 neighbours suit them. More values than the attractor has dimensions give exponents that are the
//! embedding's and not the system's, often the first of all by linear maps; [`reversal`] tells them. Quadratic maps, extrapolated, mostly
//! have none: of five values of Hénon's x the first two exponents are 0.4192 and −1.6231, by linear maps 0.87 and 0.59. [`lacks_columns`] says whether
//! several columns are fewer than a state.
//!
//! # Second opinions
//! [`divergence`] finds the largest exponent without maps, from how neighbours part (Rosenstein, Kantz), and finds the straight part of the
//! curves by a rule. [`surrogate_test`] says whether a series is told from linear noise of the same spectrum and the same values.
//!
//! # Noise
//! Noise of the points that a map is fitted to flattens it: a slope is too small by the part of their variance that is noise. What the maps
//! leave unpredicted shows how much that may be, and where it is more than two errors an exponent is [`Status::Noisy`].
//!
//! # When an exponent is minus infinity, and when unidentified
//! In a stick phase the velocity is the belt's, exactly. Neighbours in such a phase do not differ in it: the neighbour
//! matrix has a singular value at rounding, the map is undetermined in that direction, and the pseudo-inverse's zero
//! there is a convention. A zero found that way says nothing. But where a stick phase begins, neighbours that
//! still differ in velocity are taken to ones that do not: that map *is* determined in n directions and has rank
//! n − 1. So at every step the rank of the neighbour matrix is compared with the rank of the map. What is
//! missing in the first is counted as undetermined, what is missing only in the second as a collapse. An exponent is
//! [`Status::Annihilated`] if its direction is tangent and collapsed at least once: no later growth brings back what
//! is zero. It is [`Status::Unidentified`] if its direction is not tangent, or undetermined by the linear maps of Eq. (25) at more than 1 % of
//! the reference points, and [`Status::Undetermined`] if it is by those that are extrapolated only. After a collapse the lost vector is
//! replaced by one orthogonal to the others, in the last position.
//!
//! A collapse is seen where the images do not differ in some direction at all, as velocities in
//! stick. Images on a curved line lose a dimension, too, but a linear fit to them keeps the
//! curvature and reports a strong contraction.
//!
//! An attractor that passes through stick phases regularly has fewer dimensions afterwards, too,
//! and then the direction is not tangent anywhere: the usual verdict for such data is
//! `unidentified`, not `annihilated`. The spectrum from the equations can tell, the data cannot.
//!
//! # Same bits
//! Maps are computed in parallel, each on its own; everything that adds up over points is sequential. Distances are compared
//! with ties broken by index. The result does not depend on the number of threads or on the machine.

mod averages;
mod chain;
mod cloud;
mod directions;
mod divergence;
mod embedding;
mod error;
mod estimate;
mod evidence;
mod extrapolation;
mod fit;
mod least_squares;
mod matrix;
mod neighbours;
mod polynomial;
mod result;
mod reversal;
mod series;
mod settings;
pub mod statistics;
mod surrogates;
mod svd;
mod tree;

pub use directions::{Direction, Kind};
pub use divergence::{Divergence, DivergenceCurve, StraightPart, divergence};
pub use embedding::{
    DelayReason, DimensionEvidence, DimensionReason, Embedding, EmbeddingChoice, EmbeddingSettings,
    NO_FALSE_NEIGHBOURS, choose_embedding, lacks_columns, needed_embedding,
};
pub use error::DataError;
pub use estimate::{data_spectrum, data_spectrum_with};
pub use extrapolation::Sizes;
pub use polynomial::Degree;
pub use result::{Balance, Counts, DataExponent, DataSpectrum, Running, Status};
pub use reversal::{Origin, Reversal, reversal};
pub use series::{MAX_COLUMNS, Series};
pub use settings::{DataSettings, Estimator, FEWEST_REFERENCES, Neighbourhood};
pub use surrogates::{
    FEWEST_SURROGATES, MOST_SURROGATES, Statistics, SurrogateTest, check_surrogates, surrogate_test,
};
