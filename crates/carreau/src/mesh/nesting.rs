//! Closed components: the volume they enclose, how deep they are nested in each other, and which are inside out.

use super::connectivity::Connectivity;
use super::polygons::Polygons;
use super::triangles::NONE;
use glam::DVec3;
use robust::{Coord, Coord3D, orient2d, orient3d};

/// The closed, consistently oriented components of a surface.
pub(crate) struct Shells {
    /// Shell of every component, `u32::MAX` where it is none.
    of_component: Vec<u32>,
    /// Enclosed volume, negative where the faces look inward.
    pub volume: Vec<f64>,
    /// In how many other shells each lies.
    pub depth: Vec<u32>,
    bounds: Vec<(DVec3, DVec3)>,
    /// Which shell lies in which other one.
    inside: Vec<[u32; 2]>,
    /// The component of every shell, and a face of it.
    component: Vec<u32>,
    first_face: Vec<u32>,
}

impl Shells {
    /// Finds the shells among the components.
    pub fn of(points: &[DVec3], faces: &Polygons, parts: &Connectivity, ignore: &[bool]) -> Self {
        let mut is_shell = parts.closed.clone();
        let mut exclude = |f: usize| is_shell[parts.component[f] as usize] = false;
        (0..faces.len()).filter(|&f| ignore[f] || parts.turned[f]).for_each(&mut exclude);
        is_shell.iter_mut().zip(&parts.orientable).for_each(|(shell, &orientable)| *shell &= orientable);
        let mut count = 0;
        let number = |&shell: &bool| {
            count += u32::from(shell);
            if shell { count - 1 } else { NONE }
        };
        let of_component: Vec<u32> = is_shell.iter().map(number).collect();
        let of_face: Vec<u32> = parts.component.iter().map(|&c| of_component[c as usize]).collect();
        let (volume, bounds) = volumes_and_bounds(points, faces, &of_face, count as usize);
        let (mut component, mut first_face) = (vec![NONE; count as usize], vec![NONE; count as usize]);
        for (f, &shell) in (0u32..).zip(&of_face).filter(|&(_, &shell)| shell != NONE) {
            if first_face[shell as usize] == NONE {
                (component[shell as usize], first_face[shell as usize]) = (parts.component[f as usize], f);
            }
        }
        let depth = vec![0; count as usize];
        let mut shells = Shells { of_component, volume, depth, bounds, inside: Vec::new(), component, first_face };
        shells.find_depths(points, faces, &of_face);
        shells
    }

    /// None at all.
    pub fn none() -> Self {
        Shells {
            of_component: Vec::new(),
            volume: Vec::new(),
            depth: Vec::new(),
            bounds: Vec::new(),
            inside: Vec::new(),
            component: Vec::new(),
            first_face: Vec::new(),
        }
    }

    /// Number of shells.
    pub fn len(&self) -> usize {
        self.volume.len()
    }

    /// Shells for which this holds, by a face of the inner and one of the outer, are no cavities of each other.
    pub fn tell_apart(&mut self, apart: impl Fn(u32, u32) -> bool) {
        let face = |shell: u32| self.first_face[shell as usize];
        let (depth, inside) = (&mut self.depth, &mut self.inside);
        inside.retain(|&[inner, outer]| {
            let keep = !apart(face(inner), face(outer));
            depth[inner as usize] -= u32::from(!keep);
            keep
        });
    }

    /// The component whose cavity a component is; itself where it is none.
    pub fn body(&self, component: u32) -> u32 {
        let shell = self.of_component[component as usize];
        let Some(&depth) = self.depth.get(shell as usize).filter(|depth| *depth % 2 == 1) else { return component };
        let around =
            self.inside.iter().find(|[inner, outer]| *inner == shell && self.depth[*outer as usize] + 1 == depth);
        around.map_or(component, |&[_, outer]| self.component[outer as usize])
    }

    /// Whether a component looks the wrong way: inward outside, outward as a cavity. A volume within rounding of zero
    /// says nothing.
    pub fn is_inverted(&self, component: u32) -> bool {
        let shell = self.of_component[component as usize] as usize;
        let Some(&volume) = self.volume.get(shell) else { return false };
        let extent = self.bounds[shell].1 - self.bounds[shell].0;
        let box_volume = extent.x * extent.y * extent.z;
        volume.abs() > 1e-12 * box_volume && (volume < 0.0) != (self.depth[shell] % 2 == 1)
    }

    /// A shell lies in another when both its highest and its lowest vertex do and its box lies in the other's box.
    fn find_depths(&mut self, points: &[DVec3], faces: &Polygons, of_face: &[u32]) {
        if self.len() < 2 {
            return;
        }
        let probes = Probes::new(points, faces, of_face, self.len());
        let (triangles, parent) = faces.fan();
        let mut hits = Vec::new();
        for (t, f) in triangles.iter().zip(parent) {
            let shell = of_face[f as usize];
            if shell != NONE {
                probes.cross(t.map(|v| points[v as usize]), shell, &self.bounds, &mut hits);
            }
        }
        hits.sort_unstable();
        // (inner, outer) pairs, once for the upward and once for the downward ray.
        let windings = hits.chunk_by(|a, b| a.0 == b.0 && a.1 == b.1 && a.2 == b.2);
        let inside: Vec<_> = windings.filter(|run| run.iter().map(|h| i32::from(h.3)).sum::<i32>() != 0).collect();
        for pair in inside.chunk_by(|a, b| a[0].0 == b[0].0 && a[0].1 == b[0].1).filter(|pair| pair.len() == 2) {
            let (inner, outer, ..) = pair[0][0];
            self.depth[inner as usize] += 1;
            self.inside.push([inner, outer]);
        }
    }
}

fn volumes_and_bounds(
    points: &[DVec3],
    faces: &Polygons,
    of_face: &[u32],
    count: usize,
) -> (Vec<f64>, Vec<(DVec3, DVec3)>) {
    let mut origin = vec![None; count];
    let mut volume = vec![0.0; count];
    let mut bounds = vec![(DVec3::INFINITY, DVec3::NEG_INFINITY); count];
    for (face, &shell) in faces.iter().zip(of_face).filter(|&(_, &shell)| shell != NONE) {
        let k = shell as usize;
        // Relative to a vertex of the shell, so that a place far from the origin does not cost digits.
        let origin = *origin[k].get_or_insert(points[face[0] as usize]);
        let p = |i: usize| points[face[i] as usize] - origin;
        for i in 1..face.len() - 1 {
            volume[k] += p(0).dot(p(i).cross(p(i + 1))) / 6.0;
        }
        for &v in face {
            bounds[k] = (bounds[k].0.min(points[v as usize]), bounds[k].1.max(points[v as usize]));
        }
    }
    (volume, bounds)
}

/// Vertical rays from the highest vertex of every shell upward and from the lowest downward: neither meets its own
/// shell. Sorted by x, so that a triangle finds the rays in its range.
///
/// Whether a ray passes a triangle is decided with exact predicates, ties by a half-open rule that is the same for both
/// triangles of an edge (as if the ray stood at (x + ε, y + ε²)): the count of crossings is never off by one.
struct Probes {
    rays: Vec<(DVec3, u32, bool)>,
}

impl Probes {
    fn new(points: &[DVec3], faces: &Polygons, of_face: &[u32], count: usize) -> Self {
        let mut extremes: Vec<[Option<DVec3>; 2]> = vec![[None; 2]; count];
        for (face, &shell) in faces.iter().zip(of_face).filter(|&(_, &shell)| shell != NONE) {
            for &v in face {
                let p = points[v as usize];
                let [top, bottom] = &mut extremes[shell as usize];
                if top.is_none_or(|q| p.z > q.z) {
                    *top = Some(p);
                }
                if bottom.is_none_or(|q| p.z < q.z) {
                    *bottom = Some(p);
                }
            }
        }
        let rays = extremes.iter().zip(0u32..).flat_map(|([top, bottom], shell)| {
            [top.map(|p| (p, shell, true)), bottom.map(|p| (p, shell, false))].into_iter().flatten()
        });
        let mut rays: Vec<_> = rays.collect();
        rays.sort_by(|a, b| a.0.x.total_cmp(&b.0.x));
        Probes { rays }
    }

    /// Appends (inner shell, this shell, upward, sign) for every ray of a shell with a smaller box that passes the
    /// triangle.
    fn cross(&self, t: [DVec3; 3], shell: u32, bounds: &[(DVec3, DVec3)], hits: &mut Vec<(u32, u32, bool, i8)>) {
        let low = t[0].min(t[1]).min(t[2]);
        let high = t[0].max(t[1]).max(t[2]);
        let from = self.rays.partition_point(|r| r.0.x < low.x);
        let outer = bounds[shell as usize];
        for &(p, inner, up) in self.rays[from..].iter().take_while(|r| r.0.x <= high.x) {
            let own = bounds[inner as usize];
            let nested = own.0.cmpgt(outer.0).all() && own.1.cmplt(outer.1).all();
            let beyond = if up { high.z > p.z } else { low.z < p.z };
            if inner == shell || !nested || !beyond || p.y < low.y || p.y > high.y {
                continue;
            }
            let sign = plane_winding(t, p);
            if sign != 0 && (height_sign(t, p) * sign > 0) == up && height_sign(t, p) != 0 {
                hits.push((inner, shell, up, sign));
            }
        }
    }
}

/// Winding number of the triangle, seen along z, around the point.
fn plane_winding(t: [DVec3; 3], p: DVec3) -> i8 {
    let flat = |q: DVec3| Coord { x: q.x, y: q.y };
    let crossing = |a: DVec3, b: DVec3| {
        let up = a.y <= p.y;
        if up == (b.y <= p.y) {
            return 0;
        }
        let (lower, upper) = if up { (a, b) } else { (b, a) };
        match orient2d(flat(lower), flat(upper), flat(p)) > 0.0 {
            true if up => 1,
            true => -1,
            false => 0,
        }
    };
    crossing(t[0], t[1]) + crossing(t[1], t[2]) + crossing(t[2], t[0])
}

/// 1 where the point is below the plane of a triangle that is counter-clockwise seen from above, -1 above it, 0 on it.
fn height_sign(t: [DVec3; 3], p: DVec3) -> i8 {
    let c = |q: DVec3| Coord3D { x: q.x, y: q.y, z: q.z };
    match orient3d(c(t[0]), c(t[1]), c(t[2]), c(p)) {
        s if s > 0.0 => 1,
        s if s < 0.0 => -1,
        _ => 0,
    }
}
