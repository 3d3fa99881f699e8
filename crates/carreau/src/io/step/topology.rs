//! Vertices, edges, loops, faces and shells.

use super::writer::{Id, Writer, Written};
use crate::brep::{Brep, Curve, Edge, EdgeUse, Face, Shell};
use crate::io::cad::needs_parameter_curves;
use glam::DVec3;

impl Writer<'_> {
    /// Writes everything up to the shells; returns their ids, and those of the faces.
    pub(super) fn topology(&mut self, brep: &Brep, parameter_curves: bool) -> Written {
        let surfaces: Vec<Id> = brep.surfaces.iter().map(|s| self.surface(s)).collect();
        let vertices: Vec<Id> = brep.vertices.iter().map(|v| self.vertex(v.point)).collect();
        let on_faces = self.curves_on_faces(brep, &surfaces, parameter_curves);
        let edges: Vec<Id> =
            brep.edges.iter().zip(&on_faces).map(|(edge, curves)| self.edge(edge, &vertices, curves)).collect();
        let mut void = vec![false; brep.shells.len()];
        brep.solids.iter().flat_map(|s| &s.voids).for_each(|&s| void[s as usize] = true);
        let mut faces = vec![0; brep.faces.len()];
        let shell = |(shell, turned): (&Shell, bool)| {
            let mut ids = Vec::with_capacity(shell.faces.len());
            for &f in &shell.faces {
                let id = self.face(&brep.faces[f as usize], &surfaces, &vertices, &edges, turned);
                faces[f as usize] = id;
                ids.push(id);
            }
            let id = self.begin();
            self.text(if shell.closed { "CLOSED_SHELL(" } else { "OPEN_SHELL(" });
            self.string(&shell.name);
            self.out.push(b',');
            self.ids(ids);
            self.out.push(b')');
            self.end();
            id
        };
        let shells = brep.shells.iter().zip(void).map(shell).collect();
        Written { shells, faces }
    }

    pub(super) fn vertex(&mut self, p: DVec3) -> Id {
        let point = self.point(p);
        self.entity("VERTEX_POINT('',#)", &[point])
    }

    /// The PCURVEs of every edge.
    pub(super) fn curves_on_faces(&mut self, brep: &Brep, surfaces: &[Id], all: bool) -> Vec<Vec<Id>> {
        let mut out = vec![Vec::new(); brep.edges.len()];
        let wanted = |f: &Face| all || needs_parameter_curves(brep, f);
        if !brep.faces.iter().any(wanted) {
            return out;
        }
        let plane = self.entity(
            "(GEOMETRIC_REPRESENTATION_CONTEXT(2)PARAMETRIC_REPRESENTATION_CONTEXT()REPRESENTATION_CONTEXT('',''))",
            &[],
        );
        for face in brep.faces.iter().filter(|f| wanted(f)) {
            let surface = surfaces[face.surface as usize];
            for of in face.loops.iter().flatten().filter(|u| !u.parameters.is_empty()) {
                let curve = self.parameter_curve(brep, of);
                let representation = self.entity("DEFINITIONAL_REPRESENTATION('',(#),#)", &[curve, plane]);
                let on_face = self.entity("PCURVE('',#,#)", &[surface, representation]);
                out[of.edge as usize].push(on_face);
            }
        }
        out
    }

    /// A polyline in the parameter plane, with the same parameter as the edge's curve in space.
    pub(super) fn parameter_curve(&mut self, brep: &Brep, of: &EdgeUse) -> Id {
        let points: Vec<Id> = of.parameters.iter().map(|&p| self.point_2d(p)).collect();
        let edge = &brep.edges[of.edge as usize];
        let breaks = match &edge.curve {
            Curve::Spline(c) if points.len() > 2 => c.knots().breaks(),
            _ => edge.range.to_vec(),
        };
        let id = self.begin();
        self.text("B_SPLINE_CURVE_WITH_KNOTS('',1,");
        self.ids(points);
        self.text(",.POLYLINE_FORM.,.F.,.F.,");
        let last = breaks.len() - 1;
        self.list(0..=last, |w, k| w.text(if k == 0 || k == last { "2" } else { "1" }));
        self.out.push(b',');
        self.list(&breaks, |w, &t| w.real(t));
        self.text(",.UNSPECIFIED.)");
        self.end();
        id
    }

    pub(super) fn edge(&mut self, edge: &Edge, vertices: &[Id], on_faces: &[Id]) -> Id {
        let mut curve = self.curve(&edge.curve);
        if !on_faces.is_empty() {
            let id = self.begin();
            self.text("SURFACE_CURVE('',");
            self.id(curve);
            self.out.push(b',');
            self.ids(on_faces.iter().copied());
            self.text(",.CURVE_3D.)");
            self.end();
            curve = id;
        }
        let [a, b] = edge.ends.map(|v| vertices[v as usize]);
        self.entity("EDGE_CURVE('',#,#,#,.T.)", &[a, b, curve])
    }

    /// `turned` writes the face with the opposite normal: its loops, too, then run the other way round.
    pub(super) fn face(&mut self, face: &Face, surfaces: &[Id], vertices: &[Id], edges: &[Id], turned: bool) -> Id {
        let sense = if turned { ".F.)" } else { ".T.)" };
        let mut bounds = Vec::with_capacity(face.loops.len());
        for (k, uses) in face.loops.iter().enumerate() {
            let oriented: Vec<Id> = uses
                .iter()
                .map(|of| {
                    let sense = if of.reversed { "ORIENTED_EDGE('',*,*,#,.F.)" } else { "ORIENTED_EDGE('',*,*,#,.T.)" };
                    self.entity(sense, &[edges[of.edge as usize]])
                })
                .collect();
            let border = self.begin();
            self.text("EDGE_LOOP('',");
            self.ids(oriented);
            self.out.push(b')');
            self.end();
            let kind = if k == 0 { "FACE_OUTER_BOUND('',#," } else { "FACE_BOUND('',#," };
            bounds.push(self.entity(&format!("{kind}{sense}"), &[border]));
        }
        for &pole in &face.poles {
            let border = self.entity("VERTEX_LOOP('',#)", &[vertices[pole as usize]]);
            bounds.push(self.entity(&format!("FACE_BOUND('',#,{sense}"), &[border]));
        }
        let id = self.begin();
        self.text("ADVANCED_FACE(");
        self.string(&face.name);
        self.out.push(b',');
        self.ids(bounds);
        self.out.push(b',');
        self.id(surfaces[face.surface as usize]);
        self.out.push(b',');
        self.text(if face.same_sense != turned { ".T.)" } else { ".F.)" });
        self.end();
        id
    }
}
