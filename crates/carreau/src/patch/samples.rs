//! Polygons for the tests: drawn, random, and large ones of awkward shape.

use super::polygon::{BOTTOM, Cell, LEFT, NONE, Polygon, RIGHT, TOP, opposite};
use proptest::prelude::*;
use rustc_hash::FxHashMap;

/// The generator SplitMix64 (Steele, Lea, Flood 2014).
pub struct Random(pub u64);

impl Random {
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// A number below `end`.
    pub fn below(&mut self, end: usize) -> usize {
        (self.bits() % end as u64) as usize
    }

    pub fn chance(&mut self, percent: usize) -> bool {
        self.below(100) < percent
    }

    pub fn shuffle<T>(&mut self, items: &mut [T]) {
        for i in (1..items.len()).rev() {
            items.swap(i, self.below(i + 1));
        }
    }
}

/// The cells at these (row, column) places; `wall(place, side)` is asked for [`RIGHT`] and [`TOP`]. Need not connect.
pub fn place_cells(places: &[(i32, i32)], mut wall: impl FnMut((i32, i32), usize) -> bool) -> Polygon {
    let ids: FxHashMap<_, _> = places.iter().zip(0u32..).map(|(&place, id)| (place, id)).collect();
    let cell = |(&(row, col), quad)| Cell { row, col, quad, next: [NONE; 4] };
    let mut cells: Vec<Cell> = places.iter().zip(0u32..).map(cell).collect();
    for (&(row, col), id) in places.iter().zip(0u32..) {
        for (side, place) in [(RIGHT, (row, col + 1)), (TOP, (row + 1, col))] {
            if let Some(&other) = ids.get(&place)
                && !wall((row, col), side)
            {
                cells[id as usize].next[side] = other;
                cells[other as usize].next[opposite(side)] = id;
            }
        }
    }
    Polygon { cells }
}

/// The part of the polygon that connects to cell 0.
pub fn first_component(polygon: &Polygon) -> Polygon {
    let mut new_id = vec![NONE; polygon.cells.len()];
    let mut order = Vec::new();
    let mut visit = |id: u32, order: &mut Vec<u32>| {
        if id != NONE && new_id[id as usize] == NONE {
            new_id[id as usize] = order.len() as u32;
            order.push(id);
        }
    };
    visit(0, &mut order);
    let mut at = 0;
    while at < order.len() {
        for next in polygon.cells[order[at] as usize].next {
            visit(next, &mut order);
        }
        at += 1;
    }
    let renamed = |next: u32| if next == NONE { NONE } else { new_id[next as usize] };
    let cell = |&id: &u32| {
        let cell = polygon.cells[id as usize];
        Cell { next: cell.next.map(renamed), ..cell }
    };
    Polygon { cells: order.iter().map(cell).collect() }
}

/// A polygon from a drawing, top row first. `#` is a cell, `.` is none, `|` is a wall between two cells of a line; a
/// line of `-` and spaces between two rows has a wall below every `-`.
pub fn drawing(lines: &[&str]) -> Polygon {
    let (mut places, mut walls) = (Vec::new(), Vec::new());
    let is_row = |line: &&&str| line.contains(['#', '.']);
    let mut row = lines.iter().filter(is_row).count() as i32;
    for line in lines {
        if !line.contains(['#', '.']) {
            walls.extend((0..).zip(line.chars()).filter(|&(_, c)| c == '-').map(|(col, _)| ((row - 1, col), TOP)));
            continue;
        }
        row -= 1;
        let mut col = 0;
        for mark in line.chars() {
            match mark {
                '|' => walls.push(((row, col - 1), RIGHT)),
                _ => {
                    if mark == '#' {
                        places.push((row, col));
                    }
                    col += 1;
                }
            }
        }
    }
    place_cells(&places, |place, side| walls.contains(&(place, side)))
}

/// A full rectangle.
pub fn block(rows: i32, cols: i32) -> Polygon {
    block_with_walls(rows, cols, |_, _| false)
}

/// What connects to the lower left cell of a full rectangle with walls.
pub fn block_with_walls(rows: i32, cols: i32, wall: impl FnMut((i32, i32), usize) -> bool) -> Polygon {
    let places: Vec<_> = (0..rows).flat_map(|row| (0..cols).map(move |col| (row, col))).collect();
    first_component(&place_cells(&places, wall))
}

/// A random polygon of at most `most` cells inside a small box, with holes, slits and diagonal contacts.
pub fn small_random(random: &mut Random, most: usize) -> Polygon {
    let rows = 1 + random.below(6).max(random.below(6));
    let widest = (most / rows).clamp(1, 8);
    let cols = 1 + random.below(widest).max(random.below(widest));
    let (gaps, walls) = ([0, 8, 16, 24][random.below(4)], [0, 6, 12, 24, 36][random.below(5)]);
    let mut places: Vec<_> = (0..rows as i32).flat_map(|row| (0..cols as i32).map(move |col| (row, col))).collect();
    random.shuffle(&mut places);
    let first = places[0];
    places.retain(|&place| place == first || !random.chance(gaps));
    first_component(&place_cells(&places, |_, _| random.chance(walls)))
}

/// Any small polygon; shrinks towards few cells and few walls.
pub fn any_polygon() -> impl Strategy<Value = Polygon> {
    let bits = |percent: f64| prop::collection::vec(prop::bool::weighted(percent), 2 * 49);
    (1..8i32, 1..8i32, bits(0.8), bits(0.15)).prop_map(|(rows, cols, cells, walls)| {
        let mut places: Vec<_> = (0..rows).flat_map(|row| (0..cols).map(move |col| (row, col))).collect();
        places.retain(|&(row, col)| (row, col) == (0, 0) || cells[(7 * row + col) as usize]);
        let wall = |(row, col), side| walls[(7 * row + col) as usize + if side == TOP { 49 } else { 0 }];
        first_component(&place_cells(&places, wall))
    })
}

/// A blob that grows from one cell by adding random neighbours; holes appear by themselves.
pub fn grown(random: &mut Random, cells: usize, walls: usize) -> Polygon {
    let mut seen = FxHashMap::default();
    let (mut places, mut border) = (Vec::new(), vec![(0, 0)]);
    while places.len() < cells {
        let (row, col) = border.swap_remove(random.below(border.len()));
        if seen.insert((row, col), ()).is_some() {
            continue;
        }
        places.push((row, col));
        border.extend([(row - 1, col), (row + 1, col), (row, col - 1), (row, col + 1)]);
    }
    first_component(&place_cells(&places, |_, _| random.chance(walls)))
}

/// A strip of width one that winds around itself, `gap` places apart (0: separated by walls only).
pub fn spiral(cells: usize, gap: i32) -> Polygon {
    let (mut places, mut joints) = (vec![(0, 0)], rustc_hash::FxHashSet::default());
    let (mut row, mut col, mut length, mut heading) = (0, 0, 1 + gap, 0);
    while places.len() < cells {
        for _ in 0..length {
            let (dr, dc) = [(0, 1), (1, 0), (0, -1), (-1, 0)][heading % 4];
            let last = (row, col);
            (row, col) = (row + dr, col + dc);
            places.push((row, col));
            joints.insert((last.min((row, col)), if dr == 0 { RIGHT } else { TOP }));
        }
        heading += 1;
        length += if heading % 2 == 0 { 1 + gap } else { 0 };
    }
    place_cells(&places, |place, side| !joints.contains(&(place, side)))
}

/// A spine of this length with a tooth on every other cell, tooth `k` having `height(k)` cells.
pub fn comb(length: i32, height: impl Fn(i32) -> i32) -> Polygon {
    let teeth = (0..length).step_by(2).flat_map(|col| (1..=height(col / 2)).map(move |row| (row, col)));
    let places: Vec<_> = (0..length).map(|col| (0, col)).chain(teeth).collect();
    place_cells(&places, |_, _| false)
}

/// The polygon turned counter-clockwise by a quarter.
pub fn turned(polygon: &Polygon) -> Polygon {
    let turn = |cell: &Cell| {
        let [bottom, right, top, left] = cell.next;
        Cell { row: cell.col, col: -cell.row, quad: cell.quad, next: [left, bottom, right, top] }
    };
    Polygon { cells: polygon.cells.iter().map(turn).collect() }
}

/// The polygon with left and right exchanged.
pub fn mirrored(polygon: &Polygon) -> Polygon {
    let mirror = |cell: &Cell| {
        let mut next = cell.next;
        next.swap(LEFT, RIGHT);
        Cell { col: -cell.col, next, ..*cell }
    };
    Polygon { cells: polygon.cells.iter().map(mirror).collect() }
}

/// The same polygon with its cells in another order.
pub fn shuffled(polygon: &Polygon, random: &mut Random) -> Polygon {
    let mut order: Vec<u32> = (0..polygon.cells.len() as u32).collect();
    random.shuffle(&mut order);
    let mut new_id = vec![NONE; order.len()];
    for (new, &old) in (0u32..).zip(&order) {
        new_id[old as usize] = new;
    }
    let renamed = |next: u32| if next == NONE { NONE } else { new_id[next as usize] };
    let cell = |&old: &u32| {
        let cell = polygon.cells[old as usize];
        Cell { next: cell.next.map(renamed), ..cell }
    };
    Polygon { cells: order.iter().map(cell).collect() }
}

/// The large polygons on which an algorithm must stay fast, with a name for messages.
pub fn large() -> Vec<(&'static str, Polygon)> {
    let mut random = Random(7);
    let slits = |percent: usize, random: &mut Random| block_with_walls(300, 300, |_, _| random.chance(percent));
    vec![
        ("row", block(1, 100_000)),
        ("column", block(100_000, 1)),
        ("square", block(300, 300)),
        ("spiral", spiral(20_000, 3)),
        ("spiral of walls", spiral(60_000, 0)),
        ("comb", comb(3001, |k| 1 + k % 40)),
        ("upright comb", turned(&comb(3001, |k| 1 + k % 40))),
        ("rising comb", comb(401, |k| 1 + k)),
        ("triangle", place_cells(&triangle(300), |_, _| false)),
        ("blob", grown(&mut random, 10_000, 0)),
        ("blob with walls", grown(&mut random, 10_000, 20)),
        ("few slits", slits(1, &mut random)),
        ("some slits", slits(10, &mut random)),
        ("many slits", slits(35, &mut random)),
    ]
}

fn triangle(side: i32) -> Vec<(i32, i32)> {
    (0..side).flat_map(|row| (0..side - row).map(move |col| (row, col))).collect()
}

#[test]
fn samples_are_sound() {
    let mut random = Random(1);
    for _ in 0..300 {
        let p = small_random(&mut random, 20);
        for q in [turned(&p), mirrored(&p), shuffled(&p, &mut random), p] {
            q.check().unwrap();
        }
    }
    for (name, polygon) in large() {
        polygon.check().unwrap_or_else(|e| panic!("{name}: {e}"));
    }
    let p = drawing(&["##", "- ", "##"]);
    assert_eq!(p.cells.iter().map(|c| c.next[BOTTOM]).filter(|&n| n != NONE).count(), 1);
}
