//! The source with its size map: what an angle, a gradation and given sizes ask for.

use super::curves::{Curves, Kind};
use super::dihedral::Dihedral;
use super::options::RemeshOptions;
use super::output::{self, Made};
use super::radii::Radius;
use super::support::Support;
use super::work::{self, Limits, Work};
use super::{anisotropy, features, predicted, sheets, size};
use crate::context::Context;
use crate::error::{Error, Result};
use crate::geometry::features::{Creases, FoundFeatures, USUAL_ELEMENTS, length_of_squares};
use crate::mesh::{Column, EditMesh, NONE, SurfaceMesh};
use glam::DVec3;

/// Ridges get edges whose sag is this share of what they are allowed: there is room to move along the curve.
const SAG_SHARE: f64 = 0.85;
/// Sag of curve edges over their length.
const CURVE_SAG: f64 = 0.3;
/// On clean models edges of the surface sag by no more than this many tolerances of the ridges.
const SURFACE_SAG: f64 = 1.4;
/// A chord may sag by this share of the way to the next sheet, a triangle by a third more: both sheets may sag.
const SHEET_SAG: f64 = 0.25;
/// Least angle up to which sheets are looked for, as α: a wanted number may scale sizes up.
const SHEET_ALPHA: f64 = 0.5;
/// Borders may be left by the sag of a circle of this radius, a share of the diagonal.
const BORDER_RADIUS: f64 = 0.07;
/// Number of sizes, and of edges, over which a ragged border must turn to have a corner: below, there is only noise.
const BORDER_SCALE: f64 = 2.0;
/// Weight of the tilt of edges in the fit, where sin θ = 1: noise counts less the larger the sags are.
const TILT: f64 = 0.3;
/// The same for stretched edges: along them normals change little, and the gap is what counts.
const STRETCHED_TILT: f64 = 0.1;

/// The source with everything that does not depend on the angle.
pub struct Source {
    pub support: Support,
    pub curves: Curves,
    /// Smallest principal radius at every vertex.
    radius: Vec<Radius>,
    /// The direction in which the surface bends less, where edges are to be stretched; else empty.
    bend: Vec<DVec3>,
    diagonal: f64,
    /// There is noise to take out.
    pub noisy: bool,
    /// The features.
    pub found: FoundFeatures,
    /// Largest size at every vertex, where that was given.
    given: Option<Vec<f64>>,
    /// Distance to the next sheet at every vertex.
    next_sheet: Vec<f64>,
}

impl Source {
    pub fn new(mesh: &SurfaceMesh, options: &RemeshOptions, context: &Context) -> Result<Self> {
        let _stage = context.stage("support");
        if mesh.faces().is_empty() {
            return Err(Error::input("the mesh has no faces", "", ""));
        }
        let features::Reading { marks, noisy, found } = reading(mesh, options, context)?;
        let mut edit = EditMesh::new(mesh).ok_or_else(|| Error::Bug("polygons in a triangulated mesh".into()))?;
        // Ragged borders are read at the scale of the size map, which is known only roughly before the curves are.
        let scale = vec![0.01 * mesh.diagonal(); edit.vertex_slots() as usize];
        let mut curves = Curves::trace(&mut edit, &marks, &scale);
        let sharp = options.feature_angle.to_radians().cos();
        curves.find_sharp(&edit, sharp);
        if !noisy {
            curves.find_tips(&edit);
        }
        let support = Support::new(edit);
        let radius = support.radii(&curves.rank);
        let bend = if options.anisotropic { support.bends(&curves.rank) } else { Vec::new() };
        let given = given_sizes(mesh, &support.mesh, options)?;
        let next_sheet = next_sheets(mesh, &support.mesh, &radius, options, context)?;
        let diagonal = mesh.diagonal();
        let mut source = Source { support, curves, radius, bend, diagonal, noisy, found, given, next_sheet };
        if noisy && marks.contains(&Some(Kind::Border)) {
            source.set_size_map(options, context)?;
            let least = mean_border_edge(&source.support.mesh);
            let scale: Vec<f64> = source.support.size.iter().map(|h| BORDER_SCALE * h.max(least)).collect();
            source.curves = Curves::trace(&mut source.support.mesh, &marks, &scale);
            source.curves.find_sharp(&source.support.mesh, sharp);
        }
        Ok(source)
    }

    /// The size map of the options, graded; normals and points fitted at its scale.
    pub fn set_sizes(&mut self, options: &RemeshOptions, context: &Context) -> Result<()> {
        self.support.stretch.clear();
        self.set_size_map(options, context)?;
        self.support.fit_normals(0.5, 6);
        if self.noisy {
            self.support.fit_points(&self.curves.rank, 1.0, 0.1);
        }
        Ok(())
    }

    /// The size map alone.
    pub fn set_size_map(&mut self, options: &RemeshOptions, context: &Context) -> Result<()> {
        let _stage = context.stage("size map");
        let alpha = 2.0 * options.deviation.to_radians().sin() * options.scale;
        let (low, high) = (options.min_size * self.diagonal, options.max_size * self.diagonal);
        let tolerance = options.ridge_tolerance * self.diagonal;
        let curve_radius = self.curves.radii(alpha);
        // Where a clean model is nearly flat an angle allows much: sizes follow the sag there.
        let sag = if self.noisy { f64::INFINITY } else { SURFACE_SAG * tolerance };
        let size = |v: usize, radius: f64| {
            let r = curve_radius[v];
            // The sag of an arc is its squared chord over eight radii.
            let on_curve = (alpha * r).min((8.0 * SAG_SHARE * r * tolerance).sqrt());
            let on_surface = (alpha * radius).min(options.scale * (8.0 * radius * sag).sqrt());
            let given = self.given.as_ref().map_or(f64::INFINITY, |given| options.scale * given[v]);
            // No shorter than the edges of the source, which are as close to the next sheet.
            let between = (8.0 * SHEET_SAG * radius * self.next_sheet[v]).sqrt().max(self.radius[v].spacing);
            on_surface.min(on_curve).min(given).min(options.scale * between).max(low).min(high)
        };
        let mut radius: Vec<f64> = self.radius.iter().map(|r| r.at_scale(alpha)).collect();
        if self.noisy {
            radius = self.support.steady_radii(radius, &self.curves.rank, alpha);
        }
        // No size is small enough for a tip: those of its neighbours will do.
        self.curves.tips.iter().for_each(|&v| radius[v as usize] = f64::INFINITY);
        self.support.size = radius.iter().enumerate().map(|(v, &r)| size(v, r)).collect();
        if let Some(beta) = options.gradation {
            size::grade(&self.support.rings, &mut self.support.size, beta, context)?;
        }
        // A search for a scale does with those of its first step.
        if options.anisotropic && self.support.stretch.is_empty() {
            let rank = &self.curves.rank;
            self.support.stretch = anisotropy::stretches(&self.support, &self.bend, rank, options.gradation);
        }
        Ok(())
    }

    /// The source adapted to its size map.
    pub fn adapted(
        &self,
        mesh: &SurfaceMesh,
        options: &RemeshOptions,
        curved: bool,
        context: &Context,
    ) -> Result<SurfaceMesh> {
        let mut work = self.at_work(options);
        work.curved = curved;
        work.adapt(options.triangles, context)?;
        self.finish(mesh, &work)
    }

    /// The source itself, as the mesh to begin with.
    pub fn at_work(&self, options: &RemeshOptions) -> Work<'_> {
        Work::new(&self.support, &self.curves, self.limits(options))
    }

    /// What was adapted, as a surface mesh.
    fn finish(&self, mesh: &SurfaceMesh, work: &Work) -> Result<SurfaceMesh> {
        let seat = |corner: u32| work.seat[work.mesh.wedge(corner) as usize];
        let size = |v: u32| work.size[v as usize] / work::BALANCE;
        output::assemble(
            mesh,
            &self.support,
            &Made { mesh: &work.mesh, seat: &seat, size: &size, stretch: &work.stretch },
        )
    }

    fn limits(&self, options: &RemeshOptions) -> Limits {
        // The angle that the scaled sizes stand for.
        let theta = (options.deviation.to_radians().sin() * options.scale).min(0.9).asin();
        let on_sphere = (2.0 * theta.sin() / 3f64.sqrt()).min(0.95).asin();
        // Noise needs room; clean models do without.
        let (least, most, cap) = if self.noisy { (45.0, 60.0, 60.0) } else { (10.0, 20.0, 25.0) };
        let allowed = (1.25 * on_sphere).clamp(f64::to_radians(least), f64::to_radians(most));
        Limits {
            cos_allowed: allowed.cos(),
            cos_cap: f64::to_radians(cap).cos(),
            curve_sag_share: CURVE_SAG,
            ridge_sag: options.ridge_tolerance * self.diagonal,
            clean: !self.noisy,
            good: if self.noisy { [0.75, 0.65] } else { [0.5, 0.5] },
            border_sag: BORDER_RADIUS * self.diagonal * (1.0 - theta.cos()),
            tilt_weight: if options.anisotropic { STRETCHED_TILT } else { (TILT / theta.sin()).min(1.0) },
            dihedral: (!self.noisy && options.feature_angle < 180.0).then(|| Dihedral::within(options.feature_angle)),
        }
    }
}

/// The curves, where creases are wanted at the size of the result: at that of the wanted triangles, or else at that of an even
/// mesh of as many triangles as the sizes ask for, which vary. Only where edges are noisy the size matters.
fn reading(mesh: &SurfaceMesh, options: &RemeshOptions, context: &Context) -> Result<features::Reading> {
    let at = |size: f64| RemeshOptions { creases: Creases::AtSize(size), ..options.clone() };
    match (options.creases, options.triangles) {
        (Creases::Auto, Some(wanted)) => features::read(mesh, &at(length_of_triangles(mesh, wanted as f64)), context),
        (Creases::Auto, None) => {
            let first = at(length_of_squares(mesh, USUAL_ELEMENTS));
            let reading = features::read(mesh, &first, context)?;
            if !reading.found.noise.is_high() {
                return Ok(reading);
            }
            let mut source = Source::new(mesh, &first, context)?;
            source.set_size_map(options, context)?;
            features::read(mesh, &at(length_of_triangles(mesh, predicted::predicted(&source.support))), context)
        }
        _ => features::read(mesh, options, context),
    }
}

/// Edge length of equilateral triangles, given their number, that cover a surface.
fn length_of_triangles(mesh: &SurfaceMesh, count: f64) -> f64 {
    // An even triangle is √3 / 4 of the square of its edge.
    length_of_squares(mesh, 0.25 * 3f64.sqrt() * count)
}

/// Mean length of the edges with one triangle; 0 where there are none.
fn mean_border_edge(mesh: &EditMesh) -> f64 {
    let length = |h: u32| mesh.points[mesh.vertex(h) as usize].distance(mesh.points[mesh.head(h) as usize]);
    let border = mesh.edges().filter(|&h| mesh.opposite(h) == NONE);
    let (sum, count) = border.fold((0.0, 0), |(sum, count), h| (sum + length(h), count + 1));
    sum / f64::from(count.max(1))
}

/// How far it is to the next sheet at the vertices of the mesh at work, as far as sizes could sag.
fn next_sheets(
    mesh: &SurfaceMesh,
    edit: &EditMesh,
    radius: &[Radius],
    options: &RemeshOptions,
    context: &Context,
) -> Result<Vec<f64>> {
    let alpha = (2.0 * options.deviation.to_radians().sin()).max(SHEET_ALPHA);
    let largest = options.max_size * mesh.diagonal();
    let mut reach = vec![0.0f64; mesh.vertex_count()];
    for v in 0..edit.vertex_slots() as usize {
        let r = radius[v].at_scale(alpha);
        let longest = (alpha * r).min(largest);
        let far = longest * longest / (8.0 * SHEET_SAG * r);
        let known = &mut reach[edit.origin[v] as usize];
        // Where the surface is plane nothing sags.
        *known = if far.is_finite() { known.max(far) } else { *known };
    }
    let found = sheets::distances(mesh, |v| reach[v], context)?;
    Ok((0..edit.vertex_slots()).map(|v| found[edit.origin[v as usize] as usize]).collect())
}

/// The sizes that a vertex property asks for, at the vertices of the mesh at work.
fn given_sizes(mesh: &SurfaceMesh, edit: &EditMesh, options: &RemeshOptions) -> Result<Option<Vec<f64>>> {
    let Some(name) = &options.sizes else { return Ok(None) };
    let Some(Column::Scalar(given)) = mesh.attributes.vertex.get(name) else {
        return Err(Error::Options(format!("the mesh has no vertex property '{name}' of numbers")));
    };
    if let Some(v) = given.iter().position(|h| !(h.is_finite() && *h > 0.0)) {
        return Err(Error::Options(format!("'{name}' is {} at vertex {v}, sizes must be above 0", given[v])));
    }
    Ok(Some((0..edit.vertex_slots()).map(|v| given[edit.origin[v as usize] as usize]).collect()))
}
