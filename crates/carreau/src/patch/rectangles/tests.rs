//! Rectangles against a new search after each removal.

use super::super::samples::{Random, any_polygon, drawing, grown, large, shuffled, small_random};
use super::*;
use proptest::prelude::*;

const RULES: [CornerRule; 2] = [CornerRule::LongestRow, CornerRule::AnyWidth];

fn shape(r: &Rectangle) -> (i32, i32, u32, u32) {
    (r.row, r.col, r.rows, r.cols)
}

fn dissect(polygon: &Polygon, rule: CornerRule) -> Vec<(i32, i32, u32, u32)> {
    let rectangles = greedy(polygon, rule, &Context::new()).unwrap();
    polygon.check_dissection(&rectangles).unwrap();
    rectangles.iter().map(shape).collect()
}

/// The method as the module states it: a search through everything after each removal.
fn rescan(polygon: &Polygon, rule: CornerRule) -> Vec<(i32, i32, u32, u32)> {
    let mut links = Links::of(polygon);
    let mut left: Vec<u32> = (0..links.len()).collect();
    let mut found = Vec::new();
    while !left.is_empty() {
        let (best, cells) = left
            .iter()
            .flat_map(|&corner| candidates(corner, rule, &links))
            .map(|(rows, cols, cells)| {
                let (row, col) =
                    cells.iter().map(|&c| &polygon.cells[c as usize]).map(|c| (c.row, c.col)).min().unwrap();
                ((rows * cols, rows + cols, cols, Reverse(row), Reverse(col)), cells)
            })
            .max()
            .unwrap();
        let (area, _, cols, Reverse(row), Reverse(col)) = best;
        found.push((row, col, area / cols, cols));
        left.retain(|cell| !cells.contains(cell));
        for cell in cells {
            for side in [BOTTOM, RIGHT, TOP, LEFT] {
                links.cut(cell, side);
            }
        }
    }
    found
}

/// The candidates (rows, columns, cells) with this upper left corner.
fn candidates(corner: u32, rule: CornerRule, links: &Links) -> Vec<(u32, u32, Vec<u32>)> {
    let line = |cell: u32, side: usize, most: usize| {
        let next = move |&cell: &u32| Some(links.next(cell, side)).filter(|&next| next != NONE);
        std::iter::successors(Some(cell), next).take(most).collect::<Vec<u32>>()
    };
    let longest = line(corner, RIGHT, usize::MAX).len();
    let widths = if rule == CornerRule::LongestRow { longest..=longest } else { 1..=longest };
    let mut found = Vec::new();
    for width in widths {
        let mut cells = Vec::new();
        for (i, &first) in line(corner, BOTTOM, usize::MAX).iter().enumerate() {
            let row = line(first, RIGHT, width);
            let joined = i == 0 || row.iter().all(|&cell| links.joined(cell, TOP));
            if row.len() < width || !joined {
                break;
            }
            cells.extend(row);
            found.push(((i + 1) as u32, width as u32, cells.clone()));
        }
        if rule == CornerRule::LongestRow {
            found = found.pop().into_iter().collect();
        }
    }
    found
}

#[test]
fn equals_a_new_search_after_each_removal() {
    let mut random = Random(11);
    for case in 0..1500 {
        let size = 12 + random.below(50);
        let walls = [0, 10, 25][case % 3];
        let p = if case < 1200 { small_random(&mut random, 42) } else { grown(&mut random, size, walls) };
        for rule in RULES {
            assert_eq!(dissect(&p, rule), rescan(&p, rule), "case {case}, {rule:?}, {p:?}");
        }
    }
}

#[test]
fn the_numbering_of_cells_does_not_matter() {
    let mut random = Random(12);
    for _ in 0..300 {
        let p = small_random(&mut random, 42);
        let q = shuffled(&p, &mut random);
        for rule in RULES {
            assert_eq!(dissect(&p, rule), dissect(&q, rule));
        }
    }
}

#[test]
fn the_longest_row_is_not_always_best() {
    let p = drawing(&["####", "##..", "##..", "##.."]);
    assert_eq!(dissect(&p, CornerRule::AnyWidth), [(0, 0, 4, 2), (3, 2, 1, 2)]);
    // The paper's largest candidate has its corner below.
    assert_eq!(dissect(&p, CornerRule::LongestRow), [(0, 0, 3, 2), (3, 0, 1, 4)]);
}

/// In the paper's figure 9 the greedy choice costs a rectangle; here the 3 × 2 in the middle does.
#[test]
fn largest_first_is_not_minimal() {
    let p = drawing(&["##..", "####", "####", "..##"]);
    assert_eq!(dissect(&p, CornerRule::AnyWidth).len(), 3);
    assert_eq!(crate::patch::dissection::minimum(&p, &Context::new()).unwrap().len(), 2);
}

#[test]
fn large_polygons() {
    for (name, polygon) in large() {
        for rule in RULES {
            let rectangles = greedy(&polygon, rule, &Context::new()).unwrap();
            polygon.check_dissection(&rectangles).unwrap_or_else(|e| panic!("{name}: {e}"));
            if rule == CornerRule::AnyWidth {
                let descending = rectangles.is_sorted_by_key(|r| Reverse(r.area()));
                assert!(descending, "{name}");
            }
        }
    }
}

#[test]
fn cancelled_runs_stop() {
    let late = Context::new().with_deadline(std::time::Instant::now());
    assert!(greedy(&drawing(&["##"]), CornerRule::AnyWidth, &late).is_err());
    assert!(greedy(&Polygon::default(), CornerRule::AnyWidth, &Context::new()).unwrap().is_empty());
}

proptest! {
    #[test]
    fn rectangles_cover_each_cell_once(polygon in any_polygon()) {
        for rule in RULES {
            let rectangles = greedy(&polygon, rule, &Context::new()).unwrap();
            polygon.check_dissection(&rectangles).unwrap();
            prop_assert_eq!(rectangles.iter().map(shape).collect::<Vec<_>>(), rescan(&polygon, rule));
        }
    }
}
