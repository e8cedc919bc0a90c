//! The three stick zones between the tangent points, moved by the forcing.

/// A stick zone: an interval between two neighbouring tangent points in which the body can ride the belt.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Zone {
    /// `[T2, T1]` of Eq. (24), the listing's `k = 0`.
    Upper,
    /// `[T4, T3]`, the listing's `k = 2`.
    Middle,
    /// `[T6, T5]`, the listing's `k = 4`.
    Lower,
}

/// An end of a stick zone.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum End {
    /// The end with the larger displacement.
    Upper,
    /// The end with the smaller displacement.
    Lower,
}

impl Zone {
    /// The zone that holds `x1` when the forcing stands at `xs`, both in metres (lines 90–101).
    pub(super) fn holding(x1: f64, tangent_points: &[f64; 6], xs: f64) -> Option<Zone> {
        let [t1, t2, t3, t4, t5, t6] = tangent_points.map(|z| z + xs);
        if x1 <= t1 {
            if x1 <= t3 {
                if x1 <= t5 {
                    if x1 >= t6 {
                        return Some(Zone::Lower);
                    }
                } else if x1 >= t4 {
                    return Some(Zone::Middle);
                }
            } else if x1 >= t2 {
                return Some(Zone::Upper);
            }
        }
        None
    }
}

/// The resting positions of both ends, in metres.
///
/// A stick phase can start with no zone: the transition function and the comparison of [`Zone::holding`]
/// round differently at a zone's end. The listing's `k` is then −1, and `T[-1]` is the last tangent point
/// (its neighbour `T[k+1]`, read only with the mended exit test, the first).
pub(super) fn ends(zone: Option<Zone>, tangent_points: &[f64; 6]) -> (f64, f64) {
    let [t1, t2, t3, t4, t5, t6] = *tangent_points;
    match zone {
        Some(Zone::Upper) => (t1, t2),
        Some(Zone::Middle) => (t3, t4),
        Some(Zone::Lower) => (t5, t6),
        None => (t6, t1),
    }
}
