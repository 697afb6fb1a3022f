//! What the tangent takes from the law at a node of an interface.

use nalgebra::Matrix3;

/// State of a secondary node as the tangent sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NodeState {
    /// Components whose jump is known.
    pub stuck: [bool; 3],
    /// Other components whose unknown is the jump over its own coefficient, not the displacement:
    /// where the law is stiff beside the bulk, the two displacements of a pair are no good unknowns
    /// for a smoother.
    pub jump: [bool; 3],
    /// Derivative of the traction by the jump on the other components (Pa/m), symmetric without
    /// friction.
    pub tangent: [[f64; 3]; 3],
    /// Derivative of the tangential tractions by the normal one, of friction.
    pub friction: [f64; 3],
}

impl NodeState {
    /// Adherence in all components.
    pub const STUCK: Self =
        Self { stuck: [true; 3], jump: [false; 3], tangent: [[0.0; 3]; 3], friction: [0.0; 3] };
    /// Numbers of the packed form.
    pub const WIDTH: usize = 15;

    /// Whether the tangent of all is symmetric as far as this state goes.
    pub fn is_symmetric(&self) -> bool {
        let pairs = [(0, 1), (0, 2), (1, 2)];
        let same = |(i, j): &(usize, usize)| self.tangent[*i][*j] == self.tangent[*j][*i];
        self.friction == [0.0; 3] && pairs.iter().all(same)
    }

    /// Whether a preconditioner for this state serves the other one too: the same components are
    /// stuck, and the tangent differs by less than a part of itself, or of the stiffness of the
    /// cells at the node for each area of the interface, `cells` (Pa/m).
    pub fn is_close_to(&self, other: &Self, cells: f64) -> bool {
        const PART: f64 = 0.3;
        const PART_OF_CELLS: f64 = 0.1;
        let square = |of: &dyn Fn(usize, usize) -> f64| -> f64 {
            (0..9).map(|i| of(i / 3, i % 3).powi(2)).sum()
        };
        let change = square(&|i, j| self.tangent[i][j] - other.tangent[i][j]);
        let own = PART * PART * square(&|i, j| self.tangent[i][j]);
        self.stuck == other.stuck && change <= own.max((PART_OF_CELLS * cells).powi(2))
    }

    /// Whether some jump is answered by less traction the more of it there is.
    pub fn softens(&self) -> bool {
        let values = self.law().symmetric_eigenvalues();
        values.min() < -f64::EPSILON * values.amax()
    }

    /// The state without friction, and with the sizes of the eigenvalues of the tangent's
    /// symmetric part: positive where it softens.
    pub fn stiffened(&self) -> Self {
        if !self.softens() && self.is_symmetric() {
            return *self;
        }
        let mut eigen = self.law().symmetric_eigen();
        eigen.eigenvalues.iter_mut().for_each(|value| *value = value.abs());
        let sizes = eigen.recompose();
        let tangent = std::array::from_fn(|i| std::array::from_fn(|j| sizes[(i, j)]));
        Self { tangent, friction: [0.0; 3], ..*self }
    }

    /// The state without friction, and with the symmetric part of the tangent.
    pub fn symmetric(&self) -> Self {
        let law = self.law();
        let tangent = std::array::from_fn(|i| std::array::from_fn(|j| law[(i, j)]));
        Self { tangent, friction: [0.0; 3], ..*self }
    }

    /// The symmetric part.
    fn law(&self) -> Matrix3<f64> {
        Matrix3::from_fn(|i, j| 0.5 * (self.tangent[i][j] + self.tangent[j][i]))
    }

    /// As numbers, for the exchange between ranks.
    pub fn pack(&self) -> [f64; Self::WIDTH] {
        std::array::from_fn(|i| {
            if i >= 12 {
                self.friction[i - 12]
            } else if i >= 3 {
                self.tangent[i / 3 - 1][i % 3]
            } else if self.stuck[i] {
                1.0
            } else {
                2.0 * f64::from(u8::from(self.jump[i]))
            }
        })
    }

    /// Back from the packed form.
    pub fn unpack(words: &[f64]) -> Self {
        Self {
            stuck: std::array::from_fn(|i| words[i] == 1.0),
            jump: std::array::from_fn(|i| words[i] == 2.0),
            tangent: std::array::from_fn(|i| std::array::from_fn(|j| words[3 + 3 * i + j])),
            friction: std::array::from_fn(|i| words[12 + i]),
        }
    }
}
