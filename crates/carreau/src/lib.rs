//! carreau turns triangle surfaces into structured models: CAD faces and solids, graded meshes, spline patches, all-quad
//! meshes, curve skeletons and certified hexahedra.
//!
//! ```text
//!                        ┌─ segment ──── regions ───────────► cad ──► solids and shells (STEP, IGES)
//!                        ├─ remesh ───── graded triangles
//!   file ─► io ─► mesh ──┼─ patch ────── grids of quads on the given vertices ──► B-spline faces
//!                        ├─ field ────── frames ──► quad ──► all-quad mesh, or the motorcycle graph
//!                        └─ skeleton ─── curves with radii ─────────► hex ───► hexahedra
//! ```
//!
//! # How a call looks
//!
//! Each room of the house is a module with one method, which takes a [`mesh::SurfaceMesh`], the room's options and a [`Context`].
//! Options implement `Default`, and the defaults suit most models. The [`Context`] says how to run, never what to compute:
//! threads, seed, deadline, cancellation and progress. Every failure is an [`Error`] that says what is wrong, where, and what to
//! do about it. Results are the same to the last bit for any number of threads.
//!
//! ```
//! use carreau::{Context, remesh, sample};
//! use std::time::{Duration, Instant};
//!
//! let context = Context::new().with_threads(2)?.with_deadline(Instant::now() + Duration::from_secs(60));
//! let mesh = sample::make("torus", None, &context)?;
//! let options = remesh::RemeshOptions { deviation: 25.0, ..Default::default() };
//! let coarse = remesh::simplify(&mesh, &options, &context)?;
//! assert!(coarse.mesh.face_count() < mesh.face_count());
//! # Ok::<(), carreau::Error>(())
//! ```
//!
//! The examples of this page take their surfaces from [`sample`], which makes models by name. A file is read by [`io::read`],
//! and [`mesh::prepare`] does what the command line does to it first: it welds, orients, and drops what is no surface.
//!
//! ```no_run
//! use carreau::mesh::{PrepareOptions, Takes, prepare};
//! use carreau::{Context, io};
//!
//! let context = Context::new();
//! let surface = io::read("part.stl".as_ref())?.into_surface()?.triangulated()?;
//! let prepared = prepare(surface, &PrepareOptions::default(), Takes::Bodies, &context)?;
//! println!("{} triangles", prepared.mesh.face_count());
//! # Ok::<(), carreau::Error>(())
//! ```
//!
//! # The rooms
//!
//! ## [`segment`]: the faces of a part
//!
//! In: triangles. Out: a region for every triangle, the surface each region lies on (plane, sphere, cylinder, cone, torus) with its
//! parameters, and the lines between regions.
//!
//! ```
//! use carreau::{Context, sample, segment};
//!
//! let context = Context::new();
//! let part = sample::make("cube-cylinders", Some(24), &context)?;
//! let faces = segment::segment(&part, &segment::SegmentOptions::default(), &context)?;
//! assert_eq!(faces.regions.len(), 10);
//! assert!(faces.regions.iter().all(|region| region.primitive.is_some()));
//! # Ok::<(), carreau::Error>(())
//! ```
//!
//! ## [`cad`]: a CAD model with those faces
//!
//! In: triangles. Out: a [boundary representation](brep), in which every closed body is a solid; [`io::write_cad`] writes it as
//! STEP or IGES.
//!
//! ```
//! use carreau::{Context, cad, sample};
//!
//! let context = Context::new();
//! let part = sample::make("wedge", Some(16), &context)?;
//! let model = cad::rebuild(&part, &cad::CadOptions::default(), &context)?;
//! assert_eq!((model.brep.solids.len(), model.brep.faces.len()), (1, 5));
//! # Ok::<(), carreau::Error>(())
//! ```
//!
//! ## [`remesh`]: graded triangles
//!
//! In: triangles. Out: triangles whose size follows the curvature, so that they turn away from the surface by no more than an
//! angle; [`remesh::simplify`] coarsens, [`remesh::enrich`] refines. Sharp edges and borders stay.
//!
//! ```
//! use carreau::{Context, remesh, sample};
//!
//! let context = Context::new();
//! let mesh = sample::make("torus", Some(24), &context)?;
//! let options = remesh::RemeshOptions { deviation: 25.0, ..Default::default() };
//! let graded = remesh::simplify(&mesh, &options, &context)?;
//! assert!(graded.quality.shape_min > 0.3);
//! # Ok::<(), carreau::Error>(())
//! ```
//!
//! ## [`patch`]: grids of quads on the given vertices
//!
//! In: triangles. Out: patches, each an m × n grid of quads made of pairs of triangles; no vertex is moved or added.
//! [`patch::cad`] makes a B-spline face of each.
//!
//! ```
//! use carreau::{Context, patch, sample};
//!
//! let context = Context::new();
//! let part = sample::make("cube-cylinders", Some(24), &context)?;
//! let layout = patch::decompose(&part, &patch::PatchOptions::default(), &context)?;
//! assert!(layout.figures.coverage > 0.9);
//! # Ok::<(), carreau::Error>(())
//! ```
//!
//! ## [`field`]: a frame per triangle
//!
//! In: triangles. Out: two directions per triangle that follow every feature and leave room for a quad in every corner, however
//! acute.
//!
//! ```
//! use carreau::{Context, field, sample};
//!
//! let context = Context::new();
//! let part = sample::make("wedge", Some(16), &context)?;
//! let frames = field::field(&part, &field::FieldOptions::default(), &context)?;
//! assert_eq!(frames.poles(), [0, 0]);
//! # Ok::<(), carreau::Error>(())
//! ```
//!
//! ## [`quad`]: all-quad meshes
//!
//! In: triangles. Out: quads only, in the number asked for, with every feature a path of edges. [`quad::motorcycle_graph`]
//! gives patches for quads: tracks along a frame field, and what they enclose.
//!
//! ```
//! use carreau::{Context, quad, sample};
//!
//! let context = Context::new();
//! let part = sample::make("wedge", Some(16), &context)?;
//! let options = quad::QuadOptions { quads: 400, ..Default::default() };
//! let quads = quad::quads(&part, &options, &context)?;
//! assert!(quads.mesh.faces().iter().all(|face| face.len() == 4));
//! assert_eq!(quads.quality.inverted, 0);
//! # Ok::<(), carreau::Error>(())
//! ```
//!
//! ## [`skeleton`]: centre lines with radii
//!
//! In: a surface of tubes. Out: curves along the middle of its branches, with the radius at every node.
//!
//! ```
//! use carreau::{Context, sample, skeleton};
//!
//! let context = Context::new();
//! let vessel = sample::make("tube-tree", Some(46), &context)?;
//! let thin = skeleton::extract(&vessel, &skeleton::SkeletonOptions::default(), &context)?;
//! assert_eq!((thin.figures.cycles, thin.figures.components), (0, 1));
//! # Ok::<(), carreau::Error>(())
//! ```
//!
//! ## [`hex`]: hexahedra along a skeleton
//!
//! In: a skeleton with radii ([`hex::from_net`]), or a surface of tubes ([`hex::from_surface`]). Out: hexahedra along the
//! branches, each proven to be folded nowhere, with tagged boundary faces.
//!
//! ```
//! use carreau::mesh::CurveNet;
//! use carreau::{Context, DVec3, hex};
//!
//! let fork = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [3.5, 1.0, 0.0], [3.5, -1.0, 0.0]].map(DVec3::from);
//! let net = CurveNet::new(fork.to_vec(), vec![0.3, 0.3, 0.2, 0.2], vec![[0, 1], [1, 2], [1, 3]]);
//! let filled = hex::from_net(&net, &hex::HexOptions::default(), &Context::new())?;
//! assert!(filled.figures.quality.certified);
//! # Ok::<(), carreau::Error>(())
//! ```
//!
//! # What the rooms stand on
//!
//! | module | holds |
//! |---|---|
//! | [`mesh`] | surfaces, hexahedra, skeletons, their checks and repair |
//! | [`geometry`] | search tree, normals, features, curvature, two-sided distance |
//! | [`numeric`] | matchings, minimum cuts, sparse systems, minimisers: methods that know no geometry |
//! | [`brep`] | the boundary representation of CAD models, and its validator |
//! | [`io`] | mesh, skeleton and CAD formats, one file each; output files appear whole or not at all |
//! | [`sample`] | built-in models whose exact shape is known |
//! | [`report`] | pictures (PNG) and pages (HTML) of models and results |
//!
//! The vocabulary (patch, arc, track, sector, side, …) is defined in `docs/glossary.md` of the repository; each room's page there
//! describes what it gives, how it works and how it was measured.

pub mod bounds;
pub mod brep;
pub mod cad;
pub mod context;
pub mod error;
pub mod field;
pub mod geometry;
pub mod hex;
pub mod io;
pub mod length;
pub mod mesh;
pub mod numeric;
pub mod patch;
pub mod quad;
pub mod remesh;
pub mod report;
pub mod sample;
pub mod segment;
pub mod skeleton;
pub mod words;

pub use context::Context;
pub use error::{Error, Place, Result};
/// The vector type of points and directions (three `f64`).
pub use glam::DVec3;
pub use length::Length;
