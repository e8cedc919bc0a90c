//! Lyapunov spectrum of a series of states, without the equations: Sano and Sawada, Phys. Rev.
//! Lett. 55, 1082 (1985); Eckmann, Oseledets, Ruelle and Ciliberto, Phys. Rev. A 34, 4971 (1986);
//! Eqs. (25) and (26) of the paper.
//!
//! 1. Least squares fit the linear map that takes every point's neighbours to where they are a step
//!    later.
//! 2. Orthonormal vectors are taken through these maps along the orbit, `x_j → x_{j+d} → …`. An
//!    exponent is the mean logarithm of the stretching in its position.
//! 3. The directions in which the points of the series spread are measured. An attractor of
//!    dimension m in n columns determines m exponents; the others come from curvature or rounding
//!    and are [`Status::Unidentified`].
//! 4. The same is done with quadratic maps from neighbourhoods of two sizes, and the exponents are
//!    extrapolated to size zero ([`Estimator::Extrapolated`], the default). The change is part of
//!    the error; an exponent that changes too much is [`Status::Unstable`].
//! 5. The fraction of the neighbours' motion that the maps predict is measured. Noise, and a single
//!    column of a system of more dimensions, are [`Status::Unpredictable`].
//!
//! Points 1 and 2 alone are [`Estimator::SanoSawada`], the estimator of the paper's Figs. 10 to 12.
//! Its value is reported with that of the default ([`DataExponent::sano_sawada`]). A second chain
//! has maps from neighbourhoods of twice the size; an exponent that changes by much more than its
//! standard error is [`Status::Unstable`].
//!
//! # What is extrapolated
//! Maps are `y' = A y + Q(u, u)`, with a quadratic form of the widest directions for each
//! component. At most 28 unknowns allow forms of all directions up to six columns. The smaller
//! neighbourhood has three points for each unknown, the larger twice as many. Directions that are
//! not tangent and that the forms explain almost completely are omitted. The maps are linear if the
//! larger neighbourhood would hold more than a twentieth of the series. They are then fitted to the
//! requested number of neighbours and to twice as many. Where linear maps are requested for a
//! longer series, their distance from quadratic ones is part of the error.
//!
//! # What "ok" promises
//! The true exponent is within two standard errors in nine of ten cases or more. This was counted
//! on 200 series of eight systems of known spectrum, of 5000 to 100000 points. The same series were
//! taken as they are, with noise of a thousandth of their spread, and as single embedded columns.
//! No constant was chosen on their starts. The tables are in
//! `examples/spectrum_coverage/README.md`. For whole states it holds from 30 reference points on
//! ([`DataSettings::references`]) that reach over two Theiler windows. Nothing is promised for
//! other noise, and for series that go through the attractor a few times only. The same holds for
//! systems with corners that few orbits visit.
//!
//! # The divergence
//! The exponents of all directions add up to the mean divergence of the system. Where it is known,
//! [`DataSpectrum::balance`] compares the sum with it, or gives the sum of the missing exponents.
//! The third exponent of the Lorenz system, which no series shows, is −14.57 that way.
//!
//! # The columns are not standardised
//! The same factor for all columns, or another order of them, changes nothing. A factor for one
//! column makes other points neighbours, and a column a thousand times larger than the others
//! decides alone. Bring columns to comparable units first.
//!
//! # The bias of Sano and Sawada's estimator
//! Linear maps leave out terms of second order. The bias shrinks with the radius, and the standard
//! error, which is statistical, does not contain it. For the Lorenz system at 45001 points 0.9056
//! and 0 come out as about 0.87 and 0.03; `eps_sensitivity` says −0.03 and 0.03. A longer step
//! helps flows (0.88 and 0.02 at `d = 5`). It hides contractions, as nothing shrinks below about
//! the relative radius: Hénon's second exponent rises from −1.6 to −1.1 at `d = 4`. Doubled
//! neighbourhoods do not show every bias: Fig. 12's second exponent, 0, comes out as 0.005 ± 0.001
//! and hardly moves. The fit of fixed rank has little bias on a smooth curve or torus. It is off by
//! many standard errors where the orbit has corners, and on a fractal it loses what it cuts off.
//!
//! # Fewer columns than the system has
//! One measured column is not a state. [`choose_embedding`] forms states of delayed values. The
//! delay is the first minimum of the average mutual information. Values on a curve have none; for
//! them it is the first zero of the autocorrelation. The number of values is the first without
//! false nearest neighbours. [`Embedding::of`] is the series of these vectors;
//! [`DataSettings::delayed`] are the settings that suit them. More values than the attractor has
//! dimensions add spurious exponents, with linear maps often the largest of all; [`reversal`]
//! identifies them. [`lacks_columns`] returns whether several columns are too few for a state.
//!
//! # Second opinions
//! [`divergence`] estimates the largest exponent without maps, from the divergence of neighbours
//! (Rosenstein, Kantz). [`surrogate_test`] compares the series with linear noise of the same
//! spectrum and values.
//!
//! # Noise
//! Noise of the points flattens the maps: a slope is too small by the fraction of the neighbours'
//! variance that is noise. The unpredicted part of the images bounds this effect. Where the bound
//! exceeds two errors, an exponent is [`Status::Noisy`].
//!
//! # When an exponent is minus infinity, and when unidentified
//! In a stick phase the velocity is the belt's, exactly. Neighbours in it do not differ in
//! velocity: the map is undetermined there, and a zero of the pseudo-inverse says nothing. Where a
//! stick phase begins, neighbours that still differ are taken to ones that do not: that map *is*
//! determined and has one rank less. So at every step the rank of the neighbour matrix is compared
//! with that of the map. A direction missing in the first is undetermined; one missing only in the
//! second collapses. An exponent is [`Status::Annihilated`] if its direction is tangent and
//! collapsed at least once. It is [`Status::Unidentified`] if its direction is not tangent, or
//! undetermined by Eq. (25) at more than 1 % of the reference points, and [`Status::Undetermined`]
//! if it is so by the maps that are extrapolated only. A vector that is lost is replaced by one
//! orthogonal to the others, in the last position.
//!
//! Images on a curved line lose a dimension, too, but a linear fit reports a strong contraction
//! instead. An attractor that sticks regularly has fewer dimensions afterwards. The lost direction
//! is not tangent anywhere, and the usual status is `unidentified`. The equations can decide this,
//! the data cannot.
//!
//! # Same bits
//! Maps are computed in parallel, each on its own; sums over points are sequential. Equal distances
//! are ordered by index. The result depends neither on the number of threads nor on the machine.

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
mod progress;
mod result;
mod reversal;
mod series;
mod settings;
mod surrogates;
mod svd;
mod tree;

pub use directions::{Direction, DirectionKind};
pub use divergence::{Divergence, DivergenceCurve, StraightPart, divergence};
pub use embedding::{
    DelayReason, DimensionEvidence, DimensionReason, Embedding, EmbeddingChoice, EmbeddingSettings,
    NO_FALSE_NEIGHBOURS, choose_embedding, lacks_columns, needed_embedding,
};
pub use error::DataError;
pub use estimate::{data_spectrum, data_spectrum_with};
pub use extrapolation::Sizes;
pub use progress::{Progress, unwatched};
pub use result::{Balance, Counts, DataExponent, DataSpectrum, OK_ERRORS, Running, Status};
pub use reversal::{Origin, Reversal, reversal, status_word};
pub use series::{MAX_COLUMNS, Series};
pub use settings::{DataSettings, Degree, Estimator, FEWEST_REFERENCES, Given, Neighbourhood};
pub use surrogates::{
    FEWEST_SURROGATES, MOST_SURROGATES, SURROGATE_SEED, Statistics, SurrogateTest,
    check_surrogates, surrogate_test,
};
