//! Ways to join the branchings of a skeleton.

/// Ways to join branchings, tried in turn until the coarsest cells can be put onto the surface. Tubes that leave a ball side by
/// side part far from its centre, and branchings on the way have no room for cells; but those of a tree do.
pub const JOININGS: [Joining; 5] = [
    Joining { within: 1.0, hubs: false },
    Joining { within: 1.0, hubs: true },
    Joining { within: 0.6, hubs: false },
    Joining { within: 1.4, hubs: false },
    Joining { within: 0.3, hubs: false },
];

/// Which branchings become one.
#[derive(Debug, Clone, Copy)]
pub struct Joining {
    /// Those closer than this share of the sum of their radii.
    pub(super) within: f64,
    /// Before that, those whose branches all aim at one point.
    pub(super) hubs: bool,
}
