//! From a sheet with walls to nodes, tracks, arcs and patches.

use super::super::source::Source;
use super::super::work::Place;
use super::draw::{Drawn, place};
use super::layout::{self, Layout, loops, patch_of};
use super::sheet::{Sheet, Wall};
use super::{Arc, CUT, FEATURE, MotorcycleGraph, Node, NodeKind, Patch, Side, Start, TRACK, Track, TrackKind};
use crate::error::Result;
use crate::mesh::{Column, NONE, SurfaceMesh, TaggedEdge, VertexId};
use glam::DVec3;
use rustc_hash::{FxHashMap, FxHashSet};

/// A share of their area, and a cosine: triangles whose vertices go to the surface keep more and turn by less, because
/// others would be folded.
const FOLD_LIMIT: f64 = 0.3;

/// Collects what the walls of a sheet are.
pub struct Builder<'a> {
    drawn: &'a Drawn,
    sheet: &'a Sheet,
    source: &'a Source,
    /// Vertices of all tracks.
    lines: Vec<(TrackKind, Vec<u32>)>,
    layout: Layout,
    /// Triangles' patches.
    patch: Vec<u32>,
    /// Quads at the head of every half-edge along a wall, as the patch on its left sees it.
    quads: Vec<i32>,
    node: Vec<u32>,
    nodes: Vec<Node>,
}

impl<'a> Builder<'a> {
    pub fn new(drawn: &'a Drawn, source: &'a Source) -> Option<Self> {
        let sheet = &drawn.sheet;
        let lines = lines(drawn);
        let ends: FxHashSet<u32> = lines.iter().flat_map(|(_, line)| [line[0], line[line.len() - 1]]).collect();
        let is_fixed = |v: u32| ends.contains(&v) || place(sheet, &drawn.coarse, v) == Some(Place::Fixed);
        let layout = Layout::new(sheet, is_fixed)?;
        let (patch, count) = patch_of(sheet);
        let mut quads = vec![0; 3 * sheet.triangles.len()];
        for (h, k) in loops(sheet, &patch, count)?.into_iter().flatten().flatten() {
            quads[h as usize] = k;
        }
        let (node, nodes) = (vec![NONE; sheet.points.len()], Vec::new());
        let mut builder = Builder { drawn, sheet, source, lines, layout, patch, quads, node, nodes };
        builder.find_nodes();
        Some(builder)
    }

    fn find_nodes(&mut self) {
        let singular: FxHashSet<u32> = self.drawn.singular.iter().map(|s| s.0).collect();
        let mut ends: Vec<u32> =
            self.layout.arcs.iter().flat_map(|a| [a.vertices[0], a.vertices[a.vertices.len() - 1]]).collect();
        ends.sort_unstable();
        ends.dedup();
        for vertex in ends {
            let around = self.sheet.around(vertex);
            let is_border = around.iter().any(|&h| self.sheet.opposite[Sheet::previous(h) as usize] == NONE);
            let features = around.iter().filter(|&&h| self.sheet.is_feature(h)).count() + usize::from(is_border);
            let kind = match features {
                0 if singular.contains(&vertex) => NodeKind::Singularity,
                0 => NodeKind::Track,
                _ if self.is_corner(vertex, features) => NodeKind::Corner,
                _ if is_border => NodeKind::Border,
                _ => NodeKind::Feature,
            };
            self.node[vertex as usize] = self.nodes.len() as u32;
            self.nodes.push(Node { vertex, kind });
        }
    }

    /// Whether features alone make a vertex a node.
    fn is_corner(&self, vertex: u32, features: usize) -> bool {
        let is_bent = || place(self.sheet, &self.drawn.coarse, vertex) == Some(Place::Fixed);
        features != 2 || is_bent() || self.feature_sectors(vertex).iter().any(|&k| k != 2)
    }

    /// Quads between the features around a vertex.
    fn feature_sectors(&self, vertex: u32) -> Vec<i32> {
        let sheet = self.sheet;
        let starts = sheet.around(vertex).into_iter().filter(|&h| sheet.is_feature(h));
        starts
            .map(|start| {
                let mut quads = 0;
                for (more, wall) in sheet.sectors(start) {
                    quads += more;
                    if wall == NONE || sheet.is_feature(wall) {
                        break;
                    }
                }
                quads
            })
            .collect()
    }

    /// The graph; `None` where a wall is neither a feature nor part of a track.
    pub fn graph(self) -> Option<Result<MotorcycleGraph>> {
        let sheet = self.sheet;
        let track = |(kind, line): &(TrackKind, Vec<u32>)| Track {
            kind: *kind,
            nodes: self.ends(line),
            vertices: line.clone(),
        };
        let tracks: Vec<Track> = self.lines.iter().map(track).collect();
        let key = |a: u32, b: u32| [a.min(b), a.max(b)];
        let mut track_of = FxHashMap::default();
        for (track, id) in tracks.iter().zip(0u32..) {
            track.vertices.windows(2).for_each(|w| {
                track_of.insert(key(w[0], w[1]), id);
            });
        }
        let arcs = self.layout.arcs.iter().map(|arc| {
            let track = track_of.get(&key(arc.vertices[0], arc.vertices[1])).copied();
            // A wall is a feature or part of a track.
            if arc.curve.is_some() != track.is_none() {
                return None;
            }
            Some(Arc { nodes: self.ends(&arc.vertices), track, vertices: arc.vertices.clone() })
        });
        let arcs: Vec<Arc> = arcs.collect::<Option<_>>()?;
        let side = |s: &layout::Side| {
            let last = s.halves.last().map_or(0, |&h| self.quads[h as usize]);
            Side { arc: s.arc, reversed: s.reversed, quads: last }
        };
        let patches = self.layout.patches.iter().map(|p| Patch {
            loops: p.loops.iter().map(|l| l.iter().map(side).collect()).collect(),
            euler: p.euler,
            corners: p.corners,
            area: p.area,
            region: p.triangles.first().map_or(0, |&t| sheet.region[t as usize]),
        });
        let patches = patches.collect();
        let starts = self.drawn.traced.starts.iter().map(|s| Start {
            vertex: s.vertex,
            inner: s.after.is_none(),
            quads: s.quads.max(0) as u32,
            tracks: sheet.tracks_at(s) as u32,
        });
        let starts = starts.collect();
        let mesh = self.mesh();
        Some(mesh.map(|mesh| MotorcycleGraph {
            mesh,
            starts,
            nodes: self.nodes,
            tracks,
            arcs,
            patches,
            warnings: self.source.surface.repaired.clone(),
            missing: self.source.surface.missing.clone(),
            features: self.source.surface.found.clone(),
        }))
    }

    fn ends(&self, vertices: &[u32]) -> [u32; 2] {
        [vertices[0], vertices[vertices.len() - 1]].map(|v| self.node[v as usize])
    }

    /// The triangles on the surface, with their columns and tags.
    fn mesh(&self) -> Result<SurfaceMesh> {
        let sheet = self.sheet;
        let mut mesh = SurfaceMesh::from_triangles(self.settled(), &sheet.triangles)?;
        let labels = |list: &[u32]| Column::Label(list.iter().map(|&l| l as i32).collect());
        mesh.attributes.face.insert("patch".into(), labels(&self.patch));
        mesh.attributes.face.insert("region".into(), labels(&sheet.region));
        let mut singularity = vec![0; sheet.points.len()];
        self.drawn.singular.iter().for_each(|&(v, k)| singularity[v as usize] = k);
        mesh.attributes.vertex.insert("singularity".into(), Column::Label(singularity));
        let walls = (0..3 * sheet.triangles.len() as u32).filter(|&h| {
            let o = sheet.opposite[h as usize];
            sheet.is_wall(h) && (o == NONE || h < o)
        });
        let tag = |h: u32| match sheet.wall[h as usize] {
            Wall::Feature(_) => FEATURE,
            Wall::Track => TRACK,
            _ => CUT,
        };
        mesh.tagged_edges =
            walls.map(|h| TaggedEdge { ends: [sheet.tail(h), sheet.head(h)].map(VertexId), tag: tag(h) }).collect();
        Ok(mesh)
    }

    /// The vertices where they belong on the source, as far as no triangle turns over: those of the sheet are on chords.
    fn settled(&self) -> Vec<DVec3> {
        let sheet = self.sheet;
        let mut points = sheet.points.clone();
        let normal = |points: &[DVec3], t: u32| {
            let [a, b, c] = sheet.triangles[t as usize].map(|v| points[v as usize]);
            (b - a).cross(c - a)
        };
        for v in 0..points.len() as u32 {
            let old = points[v as usize];
            let around = sheet.around(v);
            let to = match place(sheet, &self.drawn.coarse, v) {
                Some(Place::Fixed) => continue,
                Some(Place::Curve(curve)) => self.source.on_curve(curve, old),
                _ => self.source.on_region(sheet.region[around[0] as usize / 3], old).map(|found| found.0),
            };
            let before: Vec<DVec3> = around.iter().map(|&h| normal(&points, h / 3)).collect();
            points[v as usize] = to.unwrap_or(old);
            let folds = |(&h, before): (&u32, &DVec3)| {
                let now = normal(&points, h / 3);
                now.dot(*before) < FOLD_LIMIT * now.length() * before.length()
                    || now.length() < FOLD_LIMIT * before.length()
            };
            if around.iter().zip(&before).any(folds) {
                points[v as usize] = old;
            }
        }
        points
    }
}

/// All tracks that are walls, those that met head on joined.
fn lines(drawn: &Drawn) -> Vec<(TrackKind, Vec<u32>)> {
    let sheet = &drawn.sheet;
    let walls = |tracks: &[Vec<u32>]| -> Vec<Vec<u32>> {
        tracks.iter().map(|t| sheet.walls_along(t)).filter(|t| t.len() > 1).collect()
    };
    let [along, across] = &drawn.cuts;
    let kinds = [
        (TrackKind::Motorcycle, joined(sheet, walls(&drawn.traced.tracks))),
        (TrackKind::Cut, walls(along)),
        (TrackKind::Shortcut, walls(across)),
    ];
    kinds.into_iter().flat_map(|(kind, list)| list.into_iter().map(move |line| (kind, line))).collect()
}

/// Joins tracks that end in one vertex and go on in each other, straight on in the quads around it.
fn joined(sheet: &Sheet, mut tracks: Vec<Vec<u32>>) -> Vec<Vec<u32>> {
    let mut last: FxHashMap<[u32; 2], u32> = FxHashMap::default();
    let mut passed = FxHashSet::default();
    for (t, id) in tracks.iter().zip(0u32..) {
        if let [.., before, end] = t[..] {
            last.insert([before, end], id);
        }
        passed.extend(t[..t.len() - 1].iter().copied());
    }
    for id in 0..tracks.len() {
        let [.., before, end] = tracks[id][..] else { continue };
        if passed.contains(&end) || sheet.walls_at(end, NONE).1 {
            continue;
        }
        let Some(ahead) = straight_on(sheet, end, before) else { continue };
        let Some(&other) = last.get(&[ahead, end]).filter(|&&other| other as usize != id) else { continue };
        let rest = std::mem::take(&mut tracks[other as usize]);
        tracks[id].extend(rest.iter().rev().skip(1));
    }
    tracks.retain(|t| t.len() > 1);
    tracks
}

/// The neighbour along the wall that is two quads from the one that comes from another neighbour.
fn straight_on(sheet: &Sheet, at: u32, from: u32) -> Option<u32> {
    let start = sheet.between(at, from)?;
    let mut quads = 0;
    let walls = sheet.sectors(start).take_while(|&(_, wall)| wall != NONE && wall != start);
    for (more, wall) in walls {
        quads += more;
        if quads >= 2 {
            return (quads == 2).then(|| sheet.head(wall));
        }
    }
    None
}
