//! Turns the cells into a mesh with a tagged boundary, and certifies every cell.

use super::extend::extend;
use super::figures::Figures;
use super::refine::TubeMesh;
use super::target::Target;
use super::{HexOptions, HexResult, Order, layers, second_order};
use crate::context::Context;
use crate::error::{Error, Result};
use crate::mesh::{CurveNet, HexMesh, boundary_faces};
use crate::words::counted;

/// The mesh with its boundary faces, which are tagged: 1 the wall, 2, 3 … the ends.
pub fn with_boundary(
    tube: TubeMesh,
    skeleton: CurveNet,
    warnings: Vec<String>,
    options: &HexOptions,
    context: &Context,
) -> Result<HexResult> {
    let _stage = context.stage("boundary");
    let quads: Vec<[u32; 4]> = boundary_faces(&tube.hexes).into_iter().map(|f| f.0).collect();
    let tag = |q: &[u32; 4]| {
        let cap = tube.caps[q[0] as usize];
        if cap > 0 && q.iter().all(|&v| tube.caps[v as usize] == cap) { 1 + cap as i32 } else { 1 }
    };
    let tags = quads.iter().map(tag).collect();
    let mesh = HexMesh { points: tube.points, hexes: tube.hexes, quads, tags };
    let mut figures = Figures::of(&mesh, skeleton.edges.len(), options.padding, context)?;
    figures.cubic_junctions = tube.cubic_junctions;
    let bases = (0..mesh.points.len() as u32).collect();
    let origins = (0..mesh.quads.len() as u32).collect();
    Ok(HexResult { mesh, skeleton, figures, warnings, origins, flat_caps: Vec::new(), second_order: None, bases })
}

/// What is asked for beyond the cells of the shape itself, with the figures of the longer mesh; distances are those of before.
pub fn finish(result: &mut HexResult, options: &HexOptions, target: Option<&Target>, context: &Context) -> Result<()> {
    if options.layers.is_none() && options.extend.is_none() && options.order == Order::First {
        return Ok(());
    }
    if let Some(wanted) = options.layers {
        layers::add(result, wanted, context)?;
    }
    if let Some(radii) = options.extend {
        let _stage = context.stage("ends");
        extend(result, radii)?;
    }
    if options.order == Order::Second {
        second_order::raise(result, target, context)?;
    }
    let of_shape = result.figures.clone();
    let middles = result.second_order.as_ref().map_or(0, |m| m.places.len());
    let all = Figures::of(&result.mesh, of_shape.segments, of_shape.padding, context)?;
    result.figures = Figures {
        hexes: all.hexes,
        vertices: all.vertices + middles,
        boundary_quads: all.boundary_quads,
        quality: all.quality,
        ..of_shape
    };
    certify(result, options)
}

/// Refuses cells without a certificate, unless they are allowed; then a warning counts them.
pub fn certify(result: &mut HexResult, options: &HexOptions) -> Result<()> {
    let uncertified = &result.figures.quality.uncertified;
    let Some(first) = uncertified.first() else { return Ok(()) };
    let (count, all) = (uncertified.len(), result.mesh.hexes.len());
    if !options.allow_invalid {
        return Err(Error::Numeric(format!(
            "{count} of {all} hexes could not be made valid, first {first}; add padding or halve across; the option \
             allow-invalid lets such a mesh pass"
        )));
    }
    let cells = counted(count, "hex has", "hexes have");
    result.warnings.push(format!("{cells} no certificate of a positive Jacobian, first {first}"));
    Ok(())
}
