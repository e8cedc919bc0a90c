//! Linear oscillators with Coulomb friction between them, which cover every problem here.

use stickslip::{Contacts, Scalar, Side};

/// `B` bodies and as many contacts; unused bodies do not move. States: positions, then velocities.
#[derive(Clone, Debug, PartialEq)]
pub struct Rig<const B: usize> {
    pub masses: [f64; B],
    /// Force on body `i` is `-Σ stiffness[i][j] x_j`.
    pub stiffness: [[f64; B]; B],
    /// Amplitude of a force `cos ωt` on each body, and ω.
    pub forcing: [f64; B],
    pub omega: f64,
    /// Force on each body, growing linearly with time.
    pub pull: [f64; B],
    /// The velocity of contact `c` is that of body `c` relative to the body below it, or to the
    /// floor.
    pub sits_on: [Option<usize>; B],
    /// Kinetic friction of each contact.
    pub friction: [f64; B],
    /// Static over kinetic friction.
    pub ratio: f64,
}

impl<const B: usize> Rig<B> {
    /// Bodies on the floor that friction holds.
    pub fn at_rest() -> Self {
        Rig {
            masses: [1.0; B],
            stiffness: [[0.0; B]; B],
            forcing: [0.0; B],
            omega: 1.0,
            pull: [0.0; B],
            sits_on: [None; B],
            friction: [1.0; B],
            ratio: 1.0,
        }
    }

    /// Joins two bodies, or a body and the wall.
    pub fn spring(&mut self, k: f64, i: usize, j: Option<usize>) {
        self.stiffness[i][i] += k;
        if let Some(j) = j {
            self.stiffness[j][j] += k;
            self.stiffness[i][j] -= k;
            self.stiffness[j][i] -= k;
        }
    }

    fn acceleration<T: Scalar>(&self, friction: [f64; B], t: T, x: &[T]) -> [T; B] {
        let mut force = [T::zero(); B];
        for i in 0..B {
            for j in 0..B {
                if self.stiffness[i][j] != 0.0 {
                    force[i] = force[i] - x[j] * self.stiffness[i][j];
                }
            }
            if self.forcing[i] != 0.0 {
                force[i] = force[i] + (t * self.omega).cos() * self.forcing[i];
            }
            if self.pull[i] != 0.0 {
                force[i] = force[i] + t * self.pull[i];
            }
            force[i] = force[i] - friction[i];
            if let Some(below) = self.sits_on[i] {
                force[below] = force[below] + friction[i];
            }
        }
        for i in 0..B {
            force[i] = force[i] / self.masses[i];
        }
        force
    }

    fn field<T: Scalar, const N: usize>(
        &self,
        sides: &[Side; B],
        held: &[bool; B],
        t: T,
        x: &[T; N],
    ) -> [T; N] {
        let friction = std::array::from_fn(|c| {
            let ratio = if held[c] { self.ratio } else { 1.0 };
            self.friction[c] * ratio * sides[c].sign()
        });
        let acceleration = self.acceleration(friction, t, x);
        std::array::from_fn(|i| if i < B { x[B + i] } else { acceleration[i - B] })
    }

    fn boundaries<T: Scalar, const N: usize>(&self, x: &[T; N]) -> [T; B] {
        std::array::from_fn(|c| match self.sits_on[c] {
            Some(below) => x[B + c] - x[B + below],
            None => x[B + c],
        })
    }
}

macro_rules! rig {
    ($n:literal, $b:literal) => {
        impl Contacts<$n, $b> for Rig<$b> {
            fn field<T: Scalar>(&self, sides: &[Side; $b], t: T, x: &[T; $n]) -> [T; $n] {
                Rig::field(self, sides, &[false; $b], t, x)
            }
            fn boundaries<T: Scalar>(&self, _t: T, x: &[T; $n]) -> [T; $b] {
                Rig::boundaries(self, x)
            }
            fn holding<T: Scalar>(
                &self,
                sides: &[Side; $b],
                held: &[bool; $b],
                t: T,
                x: &[T; $n],
            ) -> [T; $n] {
                Rig::field(self, sides, held, t, x)
            }
        }
    };
}

rig!(6, 3);
rig!(12, 6);
