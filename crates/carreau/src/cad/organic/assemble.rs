//! Faces, edges and vertices of the model. An edge is the side of one of its faces, shared by both; a T-junction divides the edge of the
//! long side, not its face.

use super::blocks::{ArcUse, Block, Layout};
use super::control::Sheet;
use super::net::Net;
use crate::brep::{Brep, Curve, Edge, EdgeUse, Face, Surface, Vertex};
use crate::error::{Error, Result};
use crate::geometry::bspline::{BSplineCurve, BSplineSurface};
use crate::mesh::NONE;

/// The model, without shells.
pub fn assemble(net: &Net, blocks: &[Block], layout: &Layout, sheets: &[Sheet]) -> Result<Brep> {
    let mut brep = Brep::default();
    let mut vertex_of = vec![NONE; net.role.len()];
    let mut edges: Vec<Option<Edge>> = vec![None; layout.arcs.len()];
    for ((block, uses), sheet) in blocks.iter().zip(&layout.uses).zip(sheets) {
        let [u, v] = sheet.knots.clone();
        let surface = BSplineSurface::new(u, v, sheet.points.clone())?;
        let sides = surface.sides()?;
        let mut border = Vec::with_capacity(uses.len());
        for of in uses {
            let count = block.size[of.side % 2];
            let places = [of.from, of.to].map(|k| place(of.side, k, block.size));
            let known = &mut edges[of.arc as usize];
            if known.is_none() {
                let curve = part_of(&sides[of.side], of, count)?;
                let ends = layout.arcs[of.arc as usize];
                let points = curve.ends();
                let ends = [0, 1].map(|k| {
                    let id = &mut vertex_of[ends[k] as usize];
                    if *id == NONE {
                        *id = brep.vertices.len() as u32;
                        brep.vertices.push(Vertex::exact(points[k]));
                    }
                    *id
                });
                let curve = curve.between(ends.map(|v| brep.point(v)));
                let range = curve.knots().domain();
                *known = Some(Edge { curve: Curve::Spline(curve), range, ends, tolerance: 0.0 });
            }
            let parameters = if of.reversed { vec![places[1], places[0]] } else { places.to_vec() };
            border.push(EdgeUse { edge: of.arc, reversed: of.reversed, parameters });
        }
        let k = brep.surfaces.len() as u32;
        brep.faces.push(Face { region: Some(0), name: format!("bspline_{k}"), ..Face::new(k, vec![border]) });
        brep.surfaces.push(Surface::Spline(surface));
    }
    let edges: Option<Vec<Edge>> = edges.into_iter().collect();
    brep.edges = edges.ok_or_else(|| Error::Bug("a wall belongs to no block".into()))?;
    Ok(brep)
}

/// Where a place on a side is in the parameters of its block.
pub fn place(side: usize, at: usize, size: [usize; 2]) -> [f64; 2] {
    let [m, n, k] = [size[0], size[1], at].map(|x| x as f64);
    match side {
        0 => [k, 0.0],
        1 => [m, k],
        2 => [m - k, n],
        _ => [0.0, n - k],
    }
}

/// The curve of a use, counter-clockwise around its face.
fn part_of(side: &BSplineCurve, of: &ArcUse, count: usize) -> Result<BSplineCurve> {
    let backwards = of.side >= 2;
    let [low, high] = if backwards { [count - of.to, count - of.from] } else { [of.from, of.to] };
    let mut curve = side.clone();
    if high < count {
        let [before, _] = curve.split(high as f64)?;
        curve = before;
    }
    if low > 0 {
        let [_, behind] = curve.split(low as f64)?;
        curve = behind;
    }
    Ok(if backwards { curve.reversed() } else { curve })
}
