//! Which pieces form a shell, and which shells bound a solid.

use super::chain::Chains;
use super::piece::{Piece, Source};
use super::scene::Scene;
use crate::brep::{Shell, Solid};
use crate::context::Context;
use crate::error::Result;
use glam::DVec3;

/// Shells, solids, and the closed shells that are neither an outer shell nor a void of one.
pub struct Shells {
    /// All shells.
    pub shells: Vec<Shell>,
    /// The solids they bound.
    pub solids: Vec<Solid>,
    /// Closed shells with negative volume that no outer shell contains.
    pub stray_voids: usize,
}

/// Smallest volume of a solid as a share of area^1.5; below that a closed shell is flat.
const FLAT_SHELL: f64 = 1e-12;

/// A closed shell as a solid body.
struct Body {
    shell: u32,
    volume: f64,
    bounds: [DVec3; 2],
    /// Its bilinear cells (a triangle repeats its last corner).
    cells: Vec<[DVec3; 4]>,
}

/// Sorts pieces into shells, and closed shells into solids by the sign of their volume.
///
/// A closed shell with positive volume is the outer shell of a solid. One with negative volume is a void of the smallest
/// solid around it; where there is none, its faces are inside out as they are in the input, and it is left a surface.
/// So is a closed shell without volume.
pub fn shells(scene: &Scene, pieces: &[Piece], chains: &Chains, ctx: &Context) -> Result<Shells> {
    let shells = connected(pieces.len(), chains);
    let (mut outer, mut inner) = (Vec::new(), Vec::new());
    for (k, shell) in shells.iter().enumerate().filter(|(_, s)| s.closed) {
        ctx.check_every(k)?;
        let cells = shell.faces.iter().flat_map(|&f| corners(scene, &pieces[f as usize]));
        let body = Body::new(k as u32, cells.map(|c| c.map(|v| scene.point(v))).collect());
        match body.sign() {
            1 => outer.push(body),
            -1 => inner.push(body),
            _ => {}
        }
    }
    let mut solids: Vec<Solid> = outer.iter().map(|b| Solid { outer: b.shell, ..Default::default() }).collect();
    let mut stray_voids = 0;
    for body in &inner {
        ctx.check()?;
        match around(body, &outer) {
            Some(k) => solids[k].voids.push(body.shell),
            None => stray_voids += 1,
        }
    }
    Ok(Shells { shells, solids, stray_voids })
}

/// Pieces that share a chain are in one shell.
fn connected(pieces: usize, chains: &Chains) -> Vec<Shell> {
    let mut parent: Vec<u32> = (0..pieces as u32).collect();
    for &(a, b) in &chains.sides {
        if let Some(b) = b {
            let (a, b) = (root(&mut parent, a), root(&mut parent, b));
            parent[a.max(b) as usize] = a.min(b);
        }
    }
    let mut open = vec![false; pieces];
    for &(a, b) in &chains.sides {
        open[root(&mut parent, a) as usize] |= b.is_none();
    }
    let mut shell_of = vec![u32::MAX; pieces];
    let mut shells: Vec<Shell> = Vec::new();
    for piece in 0..pieces as u32 {
        let root = root(&mut parent, piece) as usize;
        if shell_of[root] == u32::MAX {
            shell_of[root] = shells.len() as u32;
            shells.push(Shell { closed: !open[root], ..Default::default() });
        }
        shells[shell_of[root] as usize].faces.push(piece);
    }
    shells
}

fn root(parent: &mut [u32], mut k: u32) -> u32 {
    while parent[k as usize] != k {
        parent[k as usize] = parent[parent[k as usize] as usize];
        k = parent[k as usize];
    }
    k
}

/// The cells of a piece; triangles repeat their last corner.
fn corners<'a>(scene: &'a Scene, piece: &'a Piece) -> Box<dyn Iterator<Item = [u32; 4]> + 'a> {
    match piece.source {
        Source::Block(b) => Box::new(b.cells(scene.patches)),
        Source::Triangle(t) => {
            let face = scene.mesh.face(t);
            Box::new(std::iter::once([face[0], face[1], face[2], face[2]]))
        }
        Source::Polygon | Source::Flat(_) => Box::new(piece.cells.iter().copied()),
    }
}

impl Body {
    fn new(shell: u32, mut cells: Vec<[DVec3; 4]>) -> Self {
        let corners = || cells.iter().flatten();
        let bounds = corners().fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[l, h], &p| [l.min(p), h.max(p)]);
        // Volumes about a point far away would cancel.
        let centre = 0.5 * (bounds[0] + bounds[1]);
        let volume = cells.iter().map(|c| bilinear_volume(c.map(|p| p - centre))).sum();
        cells.shrink_to_fit();
        Body { shell, volume, bounds, cells }
    }

    /// 1, −1, or 0 for a flat body.
    fn sign(&self) -> i32 {
        let area: f64 = self.cells.iter().map(|c| area(*c)).sum();
        if self.volume.abs() > FLAT_SHELL * area.powf(1.5) { self.volume.signum() as i32 } else { 0 }
    }

    fn contains(&self, p: DVec3) -> bool {
        let inside = p.cmpge(self.bounds[0]).all() && p.cmple(self.bounds[1]).all();
        inside && self.winding(p) > 0.5
    }

    /// How often the surface goes round a point: the sum of the solid angles of its triangles over 4π (van Oosterom and
    /// Strackee, IEEE Trans. Biomed. Eng. 30(2), 1983).
    fn winding(&self, p: DVec3) -> f64 {
        let angle = |a: DVec3, b: DVec3, c: DVec3| {
            let (la, lb, lc) = (a.length(), b.length(), c.length());
            let below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
            2.0 * a.dot(b.cross(c)).atan2(below)
        };
        let of_cell = |cell: &[DVec3; 4]| {
            let [a, b, c, d] = cell.map(|x| x - p);
            angle(a, b, c) + if c == d { 0.0 } else { angle(a, c, d) }
        };
        self.cells.iter().map(of_cell).sum::<f64>() / (4.0 * std::f64::consts::PI)
    }

    /// A point of the surface: the middle of its largest cell.
    fn sample(&self) -> DVec3 {
        let largest = self.cells.iter().fold((-1.0, DVec3::ZERO), |best, c| {
            let size = area(*c);
            let corners = if c[2] == c[3] { 3 } else { 4 };
            if size > best.0 { (size, c.iter().take(corners).sum::<DVec3>() / f64::from(corners as u32)) } else { best }
        });
        largest.1
    }
}

/// The smallest of the outer bodies that a void lies in.
fn around(void: &Body, outer: &[Body]) -> Option<usize> {
    let p = void.sample();
    let candidates = outer.iter().enumerate().filter(|(_, b)| b.volume > -void.volume && b.contains(p));
    candidates.min_by(|a, b| a.1.volume.total_cmp(&b.1.volume)).map(|(k, _)| k)
}

/// Volume between the origin and the bilinear patch through four points: ∫ S·(S_u × S_v) / 3, exact with 2 × 2 Gauss
/// points because the integrand is at most cubic in u and in v.
fn bilinear_volume([a, b, c, d]: [DVec3; 4]) -> f64 {
    const GAUSS: [f64; 2] = [0.211_324_865_405_187_1, 0.788_675_134_594_812_9];
    let (e1, e2, e3) = (b - a, d - a, a - b + c - d);
    let mut sum = 0.0;
    for u in GAUSS {
        for v in GAUSS {
            sum += (a + u * e1 + v * e2 + u * v * e3).dot((e1 + v * e3).cross(e2 + u * e3));
        }
    }
    sum / 12.0
}

/// Area of a cell by its diagonals: exact for triangles and parallelograms, else near enough to compare.
fn area([a, b, c, d]: [DVec3; 4]) -> f64 {
    0.5 * (c - a).cross(d - b).length()
}
