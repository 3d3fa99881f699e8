//! The constants of the map: what each one measures, in which unit, and why.

/// Edges of the working mesh over those of the quads, the first one because 2 to 3 triangles a quad carry as many
/// singularities as the quads can show; the others are for where nothing comes of it.
pub const WORKING_EDGES: [f64; 3] = [0.95, 0.75, 0.6];
/// A share of its longest edges: the shortest edges of the working mesh, which are of about one size because the field
/// has the singularities of smaller quads otherwise.
pub const WORKING_SMALLEST: f64 = 0.5;
/// Edges of quads: singularities of opposite sign that are nearer to each other are cancelled, because they are noise
/// at this size.
pub const CANCELLED_DISTANCE: f64 = 1.2;
/// A count: quads for each singularity at least, because with fewer the map has no room and would be tried in vain.
pub const QUADS_EACH_SINGULARITY: f64 = 4.0;
/// A count: more quads are not mapped, because memory for the factor of the map's matrix grows with about their 1.3th
/// power.
pub const MOST_MAPPED_QUADS: f64 = 200_000.0;
/// A weight over that of an edge: it holds frames that no feature and no neighbour gives a direction, small because it
/// is not to be felt elsewhere.
pub const FRAME_HOLD: f64 = 1e-9;

/// A weight over the map's stiffness, which has no unit: that of the map's constraints, as large as may be because ten
/// digits are to be left to the solution.
pub const SEAM_STIFFNESS: f64 = 1e5;
/// Edges of quads: edges on both sides of a cut differ by less, because quads are to run across it.
pub const SEAM_MISMATCH: f64 = 1e-9;
/// A count: solves with the same factor at most until they do, more than enough because each gains about five digits.
pub const MULTIPLIER_SOLVES: usize = 12;
/// A share of its wanted area: a triangle with less in the map counts as turned over, because the flat metric needs an
/// area above rounding.
pub const TURNED_AREA: f64 = 1e-3;
/// A share of its wanted area: triangles are made larger until all have so much, or as far as that goes, because those
/// that just count as whole are little better than the others.
pub const SMALL_AREA: f64 = 0.02;
/// A weight over how far a triangle is from its frame: that of the barrier against areas that vanish, small because the
/// map is to follow the field.
pub const BARRIER_WEIGHT: f64 = 0.1;
/// A share of the smallest area while it is negative: the barrier is so wide, because it must be finite on triangles
/// that are turned over.
pub const BARRIER_WIDTH: f64 = 0.2;
/// A share of the wanted area: the barrier is never less wide, because it would be too steep for Newton's method.
pub const LEAST_WIDTH: f64 = 1e-3;
/// A count: Newton's steps at most, because each of them factors the matrix anew.
pub const NEWTON_STEPS: usize = 60;
/// A count: Newton's steps without progress before it is given up, because the barrier may have to move others first.
pub const NEWTON_PATIENCE: usize = 4;
/// A share of the smallest area: it is progress where that grows by so much or fewer triangles are small, because any
/// step makes it a little larger.
pub const AREA_PROGRESS: f64 = 0.1;
/// A count: halvings of a step at most, because a millionth of it is no step any more.
pub const NEWTON_HALVINGS: usize = 20;
/// A share of what a step goes: costs are to fall by as much of themselves at least, because rounding makes them fall
/// by less.
pub const COST_DECREASE: f64 = 1e-6;
/// A count: maps that are solved for at most, because each may turn other triangles over.
pub const STIFFER_ROUNDS: usize = 12;
/// A factor of stiffness: triangles that are turned over in one map have more of it in the next, because they give way
/// to others.
pub const STIFFER_FACTOR: f64 = 2.0;
/// Radians: angles in the map are multiples of a right angle within it, because it is far from the next one, and far
/// above rounding.
pub const ANGLE_MISMATCH: f64 = 0.1;

/// Areas of quads: the least area of triangles in the flat metric, because it has to be above rounding of a map some
/// hundred quads wide.
pub const LEAST_AREA: f64 = 1e-7;
/// A count: passes over the vertices that could not be removed yet, because removing others may make room for it.
pub const REMOVAL_PASSES: usize = 20;
/// A count: flips at one vertex at most, because they may go around in circles.
pub const REMOVAL_FLIPS: usize = 400;
/// A count: flips towards Delaunay for each half-edge at most, because rounding may let them go on forever.
pub const DELAUNAY_FLIPS: usize = 40;

/// Twice an area, in quads: while numbers are rounded one after the other the mean of the rest leaves every face so
/// much, if it can, because each is to end with half a quad.
pub const FACE_ROOM: f64 = 0.6;
/// A count: rounded values that are looked at for each edge, the nearest first because those far off distort the quads.
pub const MOST_CANDIDATES: usize = 14;
/// A share of the faces: with more that have no cell after rounding, the quads are too large for the singularities, and only smaller
/// ones help; strips take a time that grows with the square of their number. Of seven surfaces that were looked at with 800 quads, six
/// scans had 18 % at most, and a coarse spring, for which there were no numbers, 30 to 40 %.
pub const MOST_BAD_SHARE: f64 = 0.25;
/// A count: orders in which edges are rounded, one after the other until all faces are positive, because another order
/// leaves room elsewhere.
pub const ROUNDING_ORDERS: usize = 4;
/// A share of their lengths: edges are shaken by it for another order, because short ones are still to come first.
pub const ORDER_SHAKE: f64 = 0.4;
/// A factor of the edges around a face that has no cell: they are to be longer in the next order, by little because ten
/// such factors make a limb of one cell one of two or three.
pub const CELL_STRETCH: f64 = 1.1;
/// A factor of the edges where quads came to nothing: they are to be longer, because a limb of two cells around becomes
/// one of three.
pub const REFINED_STRETCH: f64 = 1.4;
/// A multiple of what a number of quads that is missed costs: edges that curves lack cost so much, both as shares of
/// all, because features come first.
pub const LACKING_WEIGHT: f64 = 5.0;
/// A count of edges: curves are to be longer than they need to be by so many, because rounding takes up to half of one.
pub const SPARE_EDGES: f64 = 0.4;
/// A count: edges that a feature curve gets more the next time where a part of it is lost, because more than it needs
/// would distort the quads.
pub const MORE_EDGES: usize = 1;
/// A count: more edges are not looked for along one feature curve, because it would take as many chords for every one
/// of them.
pub const MOST_CURVE_EDGES: usize = 2_000;
/// A count: rounds of strips through faces without a cell, because each may take a cell from another face.
pub const STRIP_ROUNDS: usize = 20;
/// A count: ways for a strip from one start that are tried, in the mean, because the cheapest one may come to the same
/// face again and take its cells away.
pub const STRIP_DETOURS: usize = 4;
/// A price over the square of an error of one cell in an edge of one: what a strip costs for each edge that it crosses,
/// because of two that distort alike the shorter one is better.
pub const STRIP_STEP_PRICE: f64 = 0.02;
/// A price in the same unit: what it costs for each half cell that a face lacks then and did not before, because that
/// face needs a strip of its own.
pub const STRIP_LACK_PRICE: f64 = 5.0;
/// A count: rounds of flips of faces that are not positive, because a flip may leave another one.
pub const REPAIR_ROUNDS: usize = 40;
/// A count: more unknowns are too many for dense factors, because memory grows with their square and time with their
/// cube.
pub const MOST_UNKNOWNS: usize = 2_500;

/// A share of the number: quads of the map are so near to what is wanted, because collapses take some away later.
pub const MAPPED_WITHIN: f64 = 0.02;
/// A count: sizes that are tried for that, because whole numbers do not change evenly with the size.
pub const MOST_SIZES: usize = 10;
/// A power: the number of quads grows with that of their size where nothing else asks for any.
pub const EVEN_GROWTH: f64 = 2.0;
/// A power: it is taken to grow with that at least, because whole numbers do not change evenly with the size.
pub const LEAST_GROWTH: f64 = 0.5;
/// A count: sizes in a row that come no nearer to the number before it is given up, because features may need more quads
/// than are wanted, however large these are elsewhere.
pub const STALLED_SIZES: usize = 3;
/// A count: sizes without whole numbers before it is given up, because edges are stretched in all of their orders.
pub const FAILED_SIZES: usize = 3;
/// A count: cells that are looked at in the box of one face at most, because time grows with them.
pub const MOST_CELLS: i64 = 100_000_000;
/// A count: triangles that a straight line crosses at most, because rounding might lead it around forever.
pub const MOST_CROSSED: usize = 100_000;

/// Weight of the frames of triangles below a guide beside all others: a row of them has to stand against the field to both sides,
/// which is as wide as a limb.
pub const GUIDED_WEIGHT: f64 = 30.0;
