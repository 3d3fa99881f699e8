//! The constants of the map: what each one measures, in which unit, and why.

/// Edges of the working mesh over those of the quads: 2 to 3 triangles a quad carry as many singularities as the quads can show.
/// The others are for where nothing comes of the first.
pub const WORKING_EDGES: [f64; 3] = [0.95, 0.75, 0.6];
/// Shortest edges of the working mesh over its longest: about one size, or the field has the singularities of smaller quads.
pub const WORKING_SMALLEST: f64 = 0.5;
/// Singularities of opposite sign nearer than so many edges of quads are cancelled: they are noise at this size.
pub const CANCELLED: f64 = 1.2;
/// Fewer quads than so many for each singularity have no room for the map: it would be tried in vain.
pub const QUADS_EACH: f64 = 4.0;
/// More quads than these are not mapped: memory for the factor of the map's matrix grows with about their 1.3th power.
pub const MOST_QUADS: f64 = 200_000.0;
/// What holds frames that no feature and no neighbour gives a direction, relative to the weight of an edge.
pub const HOLD: f64 = 1e-9;

/// Weight of the constraints of the map over its stiffness, which has no unit: as large as leaves ten digits to the solution.
pub const STIFFNESS: f64 = 1e5;
/// Edges on both sides of a cut differ by less than this, in edges of quads.
pub const SEAMLESS: f64 = 1e-9;
/// Solves with the same factor at most until they do: each gains about five digits.
pub const MULTIPLIERS: usize = 12;
/// A triangle whose area in the map is less than this share of the wanted one counts as turned over: the flat metric needs an
/// area above rounding. Triangles are made larger until all have the other share, or as far as that goes.
pub const TURNED: f64 = 1e-3;
pub const SMALL: f64 = 0.02;
/// Weight of the barrier against areas that vanish, over how far a triangle is from its frame.
pub const BARRIER: f64 = 0.1;
/// The barrier is this share of the smallest area wide (area over the wanted one, while it is negative), and never less than the
/// other.
pub const WIDTH: f64 = 0.2;
pub const NO_WIDTH: f64 = 1e-3;
/// Newton's steps at most, and those without progress before it is given up: the smallest area grows by a share, or fewer are
/// small.
pub const NEWTON_STEPS: usize = 60;
pub const PATIENCE: usize = 4;
pub const PROGRESS: f64 = 0.1;
/// Halvings of a step, and by which share of what it goes costs are to fall at least.
pub const HALVINGS: usize = 20;
pub const DECREASE: f64 = 1e-6;
/// Maps that are solved for at most, each with the triangles that are turned over in the one before stiffer by a factor.
pub const STIFFER_ROUNDS: usize = 12;
pub const STIFFER: f64 = 2.0;
/// Angles in the map are multiples of a right angle within this (radians): far from the next, far above rounding.
pub const ANGLE: f64 = 0.1;

/// Least area of triangles in the flat metric, in quads: above rounding of a map some hundred quads wide.
pub const LEAST_AREA: f64 = 1e-7;
/// Passes over the vertices that could not be removed yet.
pub const REMOVAL_PASSES: usize = 20;
/// Flips at one vertex, and flips towards Delaunay for each face, at most.
pub const FLIPS: usize = 400;
pub const DELAUNAY_FLIPS: usize = 40;

/// While numbers are rounded one after the other, the mean of the rest leaves every face this area (twice, in quads), if it can.
pub const ROOM: f64 = 0.6;
/// Rounded values that are looked at for each edge, the nearest first.
pub const CANDIDATES: usize = 14;
/// Orders in which edges are rounded, one after the other until all faces are positive; lengths are shaken by this share.
pub const ORDERS: usize = 4;
pub const SHAKE: f64 = 0.4;
/// By how much edges around a face that has no cell are to be longer in the next order: ten of them make a limb of one cell one of
/// two or three.
pub const STRETCH: f64 = 1.1;
/// By how much edges are to be longer where quads came to nothing: a limb of two cells around becomes one of three.
pub const REFINED: f64 = 1.4;
/// Edges that curves lack, as a share of all that they need, count so many times more than a number of quads that is missed.
pub const LACKING: f64 = 5.0;
/// Curves are to be longer than they need to be by so many edges: rounding takes up to half of one.
pub const SPARE: f64 = 0.4;
/// Where a part of a feature curve is lost it gets so many edges more the next time.
pub const MORE_EDGES: usize = 1;
/// More edges than this are not looked for along one feature curve: it would take as many chords for every one of them.
pub const MOST_EDGES: usize = 2_000;
/// Rounds of strips through faces without a cell.
pub const MOST_STRIPS: usize = 20;
/// Ways for a strip from one start that are tried, in the mean.
pub const DETOURS: usize = 4;
/// What a strip costs for each edge that it crosses, over the square of an error of one cell in an edge of one.
pub const STRIP_STEP: f64 = 0.02;
/// The same for each half cell that a face lacks then and did not before.
pub const STRIP_LACK: f64 = 5.0;
/// Rounds of flips of faces that are not positive.
pub const REPAIRS: usize = 40;
/// More unknowns than this are too many for dense factors (memory grows with the square, time with the cube).
pub const MOST_UNKNOWNS: usize = 2_500;

/// Numbers of quads are met within this share; sizes that are tried for that.
pub const NUMBER: f64 = 0.02;
pub const SIZES: usize = 10;
/// Sizes that come no nearer to the number before it is given up: features may need more quads than are wanted, however large these
/// are elsewhere.
pub const STALLED: usize = 3;
/// Sizes without whole numbers before it is given up: edges are stretched in all of their orders.
pub const FAILED: usize = 3;
/// Cells that are looked at in the box of one face at most.
pub const MOST_CELLS: i64 = 100_000_000;
/// Triangles that a straight line crosses at most.
pub const STEPS: usize = 100_000;
