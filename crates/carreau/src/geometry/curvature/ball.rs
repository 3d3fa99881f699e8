//! Normal cycles in a ball: the tensor of [`super::normal_cycle`] with B the part of the surface within a distance.
//!
//! From the faces around the vertex, those in the ball are visited across the edges that reach into it, never across a
//! feature; every edge and every face is clipped by the ball exactly.
//!
//! Departures from the paper's authors' program: it follows only edges that lead away from the centre and so loses those
//! along the rim (a quarter of the curvature at two edge lengths); it divides by the disc's area even at borders.

use super::clip::{clipped_area, clipped_part};
use super::sectors::Sectors;
use super::tensor::{Form, Frame};
use crate::context::Context;
use crate::mesh::NONE;

/// What the visits of one thread remember.
pub(super) struct Visits {
    /// Twice the number of the last visit that found a triangle, one more once it was measured.
    seen: Vec<u64>,
    visit: u64,
    /// Triangles found and not yet measured.
    waiting: Vec<u32>,
}

impl Visits {
    pub fn new(triangles: usize) -> Self {
        Visits { seen: vec![0; triangles], visit: 0, waiting: Vec::new() }
    }
}

/// The second fundamental form in a ball around a vertex.
pub(super) struct Ball<'a> {
    /// β/|e| of every half-edge.
    pub turns: Vec<f64>,
    /// Radius of the ball.
    pub radius: f64,
    /// Stops long visits.
    pub context: &'a Context,
}

impl Ball<'_> {
    /// The form at a sector and the area of the surface in the ball. The result means nothing once the context has
    /// failed; the caller asks it again.
    pub fn at(&self, sectors: &Sectors<'_>, visits: &mut Visits, sector: u32, plane: &Frame) -> (Form, f64) {
        let Some(&first) = sectors.corners(sector).first() else { return (Form::default(), 0.0) };
        let t = &sectors.triangles;
        let centre = t.point(first);
        let square = self.radius * self.radius;
        visits.visit += 1;
        let (found, measured) = (2 * visits.visit, 2 * visits.visit + 1);
        visits.waiting.clear();
        for &c in sectors.corners(sector) {
            if visits.seen[c as usize / 3] != found {
                visits.seen[c as usize / 3] = found;
                visits.waiting.push(c / 3);
            }
        }
        let (mut sum, mut area, mut steps) = (Form::default(), 0.0, 0usize);
        while let Some(triangle) = visits.waiting.pop() {
            steps += 1;
            if self.context.check_every(steps).is_err() {
                break;
            }
            visits.seen[triangle as usize] = measured;
            let [i, j, k] = t.triangle(triangle);
            let points = t.points();
            let p = [points[i as usize] - centre, points[j as usize] - centre, points[k as usize] - centre];
            let distance = [p[0].length_squared(), p[1].length_squared(), p[2].length_squared()];
            let face = &sectors.faces[triangle as usize];
            let mut parts = [[0.0, 1.0]; 3];
            if distance[0].max(distance[1]).max(distance[2]) <= square {
                area += face.area;
            } else {
                for k in 0..3 {
                    let n = (k + 1) % 3;
                    parts[k] = clipped_part(p[k], p[n], [distance[k], distance[n]], square);
                }
                area += clipped_area(p, parts, face, square);
            }
            for k in 0..3 {
                let c = (3 * triangle) as usize + k;
                let (across, share) = (sectors.across[c], parts[k][1] - parts[k][0]);
                if across == NONE || !(share > 0.0) {
                    continue;
                }
                let neighbour = across / 3;
                let state = &mut visits.seen[neighbour as usize];
                // An edge is measured with the first of its two faces.
                if *state != measured {
                    sum = sum.plus(share * self.turns[c], plane.laid_square(p[(k + 1) % 3] - p[k]));
                    if *state != found {
                        *state = found;
                        visits.waiting.push(neighbour);
                    }
                }
            }
        }
        if !(area > 0.0) {
            return (Form::default(), 0.0);
        }
        (Form::default().plus(1.0 / area, sum.turned()), area)
    }
}
