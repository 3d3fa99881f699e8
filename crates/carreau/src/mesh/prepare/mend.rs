//! The steps of preparation and repair, each on what the one before has left.
//!
//! Which sheets there are and which way they look depend on each other where bodies touch: senses tell sheets apart, and sheets
//! tell which faces are neighbours. So both are asked in turn until nothing changes; a second preparation then finds what the
//! first has left.

use super::super::duplicates::first_on_same_vertices;
use super::super::repair::degenerate::{self, Removed};
use super::super::repair::{Soup, outward};
use super::super::surface::SurfaceMesh;
use super::separate::{first_of_sheet, separate};
use super::sides::Sides;
use super::{body_labels, doubles, folds};
use crate::context::Context;
use crate::error::Result;

/// Rounds of senses and sheets at most: two agree_and_separate all but surfaces that fold onto themselves many times.
const MENDING_ROUNDS: usize = 16;

/// Which steps are taken.
#[derive(Debug, Clone, Copy)]
pub(in crate::mesh) struct Steps {
    pub degenerate: bool,
    pub doubles: bool,
    pub orient: bool,
    /// Sheets that touch come apart.
    pub sheets: bool,
    /// What is still not manifold is cut.
    pub cut: bool,
    pub outward: bool,
}

impl Steps {
    /// Those of the preparation.
    pub const PREPARE: Steps =
        Steps { degenerate: true, doubles: true, orient: true, sheets: true, cut: false, outward: true };
}

/// A surface after the steps, and what was done.
pub(in crate::mesh) struct Mended {
    pub soup: Soup,
    /// Faces of the file without area.
    pub degenerate: Vec<u32>,
    pub removed: Removed,
    /// Faces of the file that were left out as they are there twice, each with the one that stands for it.
    pub doubles: Vec<[u32; 2]>,
    /// Pairs of faces of the file that lay on each other, as fans do that fold: both are left out.
    pub folds: Vec<[u32; 2]>,
    /// Faces of the soup that were turned to agree with their neighbours.
    pub turned: Vec<bool>,
    /// A face of every closed component that was turned.
    pub inverted: Vec<u32>,
    /// Edges of more than two faces whose sheets came apart, by vertices of the file.
    pub paired: Vec<[u32; 2]>,
    /// Number of vertices that are copies.
    pub copies: usize,
}

/// Takes the steps; `leader`: the vertex that every one becomes; `polygon`: that of every face, where faces are parts of such.
pub(in crate::mesh) fn mend(
    mesh: &SurfaceMesh,
    leader: Option<&[u32]>,
    polygon: Option<&[u32]>,
    steps: Steps,
    context: &Context,
) -> Result<Mended> {
    let diagonal = mesh.diagonal();
    let mut soup = Soup::of(mesh);
    if let Some(leader) = leader {
        soup.merge_vertices(leader);
    }
    context.check()?;
    let (mut degenerate, mut removed) = (Vec::new(), Removed::default());
    if steps.degenerate {
        degenerate = degenerate::found(&soup, diagonal).into_iter().map(|f| soup.face_source[f as usize]).collect();
        removed = degenerate::remove(&mut soup, diagonal, context)?;
    }
    context.check()?;
    let mut work = Work::new(soup, mesh, steps);
    if let Some(polygon) = polygon.filter(|_| steps.doubles) {
        work.drop_folds(polygon);
    }
    if steps.doubles {
        work.drop_doubles(context)?;
    }
    let paired = work.agree_and_separate(context)?;
    let Work { mut soup, sheet, turned, doubles, folds, .. } = work;
    let copies = if steps.sheets { separate(&mut soup, mesh, &sheet) } else { 0 };
    context.check()?;
    let inverted = if steps.outward { outward(&mut soup, body_labels(mesh)) } else { Vec::new() };
    Ok(Mended { soup, degenerate, removed, doubles, folds, turned, inverted, paired, copies })
}

/// A welded surface while sheets and senses are looked for.
struct Work<'a> {
    original: &'a SurfaceMesh,
    steps: Steps,
    soup: Soup,
    /// The sheet of every corner at its vertex.
    sheet: Vec<u32>,
    turned: Vec<bool>,
    doubles: Vec<[u32; 2]>,
    folds: Vec<[u32; 2]>,
}

impl<'a> Work<'a> {
    fn new(soup: Soup, original: &'a SurfaceMesh, steps: Steps) -> Self {
        let sheet = soup.corner_source.iter().map(|&c| original.faces().corners()[c as usize]).collect();
        let turned = vec![false; soup.faces.len()];
        Work { original, steps, soup, sheet, turned, doubles: Vec::new(), folds: Vec::new() }
    }

    /// Leaves out triangles of fans that lie on each other.
    fn drop_folds(&mut self, polygon: &[u32]) {
        let pairs = folds::folded(&self.soup, polygon);
        if pairs.is_empty() {
            return;
        }
        let mut stays = vec![true; self.soup.faces.len()];
        pairs.iter().flatten().for_each(|&f| stays[f as usize] = false);
        let source = |f: u32| self.soup.face_source[f as usize];
        self.folds.extend(pairs.iter().map(|pair| pair.map(source)));
        self.keep_faces(|f| stays[f]);
    }

    /// Leaves out what is there more often than it needs to be, until nothing is.
    fn drop_doubles(&mut self, context: &Context) -> Result<()> {
        loop {
            context.check()?;
            let kept = doubles::kept(&self.soup, self.original);
            if !self.leave_out(&kept) {
                return Ok(());
            }
        }
    }

    /// Leaves out faces for which another one stands. Whether there were any.
    fn leave_out(&mut self, kept: &[u32]) -> bool {
        let source = &self.soup.face_source;
        let gone = (0..kept.len()).filter(|&f| kept[f] as usize != f);
        let gone: Vec<[u32; 2]> = gone.map(|f| [source[f], source[kept[f] as usize]]).collect();
        if gone.is_empty() {
            return false;
        }
        let stands = |f: u32| gone.binary_search_by_key(&f, |pair| pair[0]).map_or(f, |k| gone[k][1]);
        self.doubles.iter_mut().for_each(|pair| pair[1] = stands(pair[1]));
        self.keep_faces(|f| kept[f] as usize == f);
        self.doubles.extend(gone);
        true
    }

    /// Drops all faces but some, with what is known of them.
    fn keep_faces(&mut self, stays: impl Fn(usize) -> bool) {
        let face_of = self.soup.faces.face_of_corners();
        let mut corners = face_of.iter();
        self.sheet.retain(|_| corners.next().is_some_and(|&f| stays(f as usize)));
        let mut faces = 0..self.turned.len();
        self.turned.retain(|_| faces.next().is_some_and(&stays));
        self.soup.keep_faces(stays);
    }

    /// Looks for senses and sheets in turn. Returns the edges whose sheets come apart, by vertices of the file.
    fn agree_and_separate(&mut self, context: &Context) -> Result<Vec<[u32; 2]>> {
        for _ in 0..MENDING_ROUNDS {
            context.check()?;
            self.agree();
            if !self.steps.sheets {
                return Ok(Vec::new());
            }
            context.check()?;
            let sides = Sides::new(&self.soup, &self.sheet);
            let mut sheets = sides.joined(body_labels(self.original));
            let found = sheets.of_corners(&sides, self.steps.cut);
            if sheets.crowded.is_empty() || found == self.sheet {
                let source = |v: u32| self.soup.vertex_source[v as usize];
                let paired = sheets.paired(&sides).into_iter().map(|ends| ends.map(source)).collect();
                self.sheet = found;
                return Ok(paired);
            }
            self.sheet = found;
            if self.steps.doubles {
                self.drop_doubles_of_sheets(context)?;
            }
        }
        self.agree();
        Ok(Vec::new())
    }

    /// Turns faces so that neighbours agree.
    fn agree(&mut self) {
        if !self.steps.orient {
            return;
        }
        let Some(turn) = Sides::new(&self.soup, &self.sheet).turned() else { return };
        let offsets = self.soup.faces.offsets().to_vec();
        for (f, w) in offsets.windows(2).enumerate().filter(|(f, _)| turn[*f]) {
            self.sheet[w[0] as usize + 1..w[1] as usize].reverse();
            self.turned[f] ^= true;
        }
        self.soup.turn_faces(|f| turn[f]);
    }

    /// Leaves out faces on the same vertices as another one, also after sheets have come apart; other walls may go with them.
    fn drop_doubles_of_sheets(&mut self, context: &Context) -> Result<()> {
        let mut faces = self.soup.faces.clone();
        faces.corners_mut().copy_from_slice(&first_of_sheet(&self.soup, &self.sheet));
        let kept = first_on_same_vertices(&faces, &self.soup.faces_with_repeats());
        if self.leave_out(&kept) { self.drop_doubles(context) } else { Ok(()) }
    }
}
