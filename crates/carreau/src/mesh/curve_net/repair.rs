//! Makes a net fit for a method: nodes at one place become one, edges without length go, isolated nodes go, radii that
//! are missing or zero are estimated.

use super::super::disjoint_sets::DisjointSets;
use super::super::weld::first_at_same_position;
use super::net::CurveNet;
use crate::error::{Error, Result};

/// Share of a segment's length that stands for an unknown radius.
const SHARE: f64 = 0.35;

/// A net fit for use, and what was done to it.
#[derive(Debug, Clone)]
pub struct RepairedNet {
    /// The net: all radii positive, no two nodes at one place, every node with an edge.
    pub net: CurveNet,
    /// One sentence per kind of repair.
    pub warnings: Vec<String>,
}

impl CurveNet {
    /// Repairs the net; `radius` replaces all radii when given.
    ///
    /// # Errors
    /// [`Error::Input`] when no edge with a length is left.
    pub fn repaired(&self, radius: Option<f64>) -> Result<RepairedNet> {
        let mut net = self.clone();
        let mut warnings = std::mem::take(&mut net.notes);
        net.merge_coincident(&mut warnings);
        net.drop_isolated(&mut warnings);
        if net.edges.is_empty() {
            return Err(Error::input(
                "all segments of the skeleton have zero length",
                "",
                "give nodes at different places",
            ));
        }
        match radius {
            Some(r) => net.radii.fill(r),
            None => net.estimate_radii(&mut warnings),
        }
        Ok(RepairedNet { net, warnings })
    }

    /// One node for all at one place, with the largest radius.
    fn merge_coincident(&mut self, warnings: &mut Vec<String>) {
        let first = first_at_same_position(&self.points);
        let mut sets = DisjointSets::new(self.points.len());
        (0..).zip(&first).for_each(|(v, &f)| sets.union(v, f));
        let no_length = self.edges.iter().filter(|e| first[e[0] as usize] == first[e[1] as usize]).count();
        let leader = sets.leaders();
        let merged: Vec<usize> = (0..leader.len()).filter(|&v| leader[v] != v as u32).collect();
        let Some(&example) = merged.first() else { return };
        for &v in &merged {
            let to = leader[v] as usize;
            // `max` takes the number where the other is none.
            self.radii[to] = self.radii[to].max(self.radii[v]);
        }
        self.edges.iter_mut().for_each(|e| *e = e.map(|v| leader[v as usize]));
        let gone = self.drop_multiple_edges() - no_length;
        warnings.push(format!(
            "{} nodes were merged with another at the same place, first {}; {no_length} edges had no length",
            merged.len(),
            self.ids[example]
        ));
        if gone > 0 {
            warnings.push(format!("{gone} edges were dropped, because they join the same places as others"));
        }
        let keep: Vec<bool> = leader.iter().zip(0..).map(|(&l, v)| l == v).collect();
        self.retain_nodes(&keep);
    }

    fn drop_isolated(&mut self, warnings: &mut Vec<String>) {
        let mut used = vec![false; self.points.len()];
        self.edges.as_flattened().iter().for_each(|&v| used[v as usize] = true);
        let Some(first) = used.iter().position(|u| !u) else { return };
        let count = used.iter().filter(|u| !**u).count();
        warnings.push(format!("{count} nodes without an edge were dropped, first {}", self.ids[first]));
        self.retain_nodes(&used);
    }

    /// Unknown and zero radii: the mean of the known neighbours, outwards from them; where a component knows none, a
    /// share of the lengths of the segments at the node.
    fn estimate_radii(&mut self, warnings: &mut Vec<String>) {
        let unknown: Vec<u32> = (0..).zip(&self.radii).filter(|(_, r)| !(**r > 0.0)).map(|(v, _)| v).collect();
        let Some(&first) = unknown.first() else { return };
        let around = self.incidence();
        let mut front = unknown.clone();
        loop {
            let known = |v: u32| {
                let near = around.of(v).iter().map(|&[_, w]| self.radii[w as usize]).filter(|r| *r > 0.0);
                let (sum, count) = near.fold((0.0, 0), |(s, n), r| (s + r, n + 1));
                (count > 0).then(|| sum / f64::from(count))
            };
            let found: Vec<(u32, f64)> = front.iter().filter_map(|&v| Some((v, known(v)?))).collect();
            if found.is_empty() {
                break;
            }
            found.iter().for_each(|&(v, r)| self.radii[v as usize] = r);
            front.retain(|&v| !(self.radii[v as usize] > 0.0));
        }
        for &v in &front {
            let lengths = around.of(v).iter().map(|&[e, _]| self.length(e as usize));
            self.radii[v as usize] = SHARE * lengths.sum::<f64>() / around.valence(v).max(1) as f64;
        }
        let how = if front.is_empty() { "from their neighbours" } else { "from the lengths of the segments" };
        warnings.push(format!(
            "{} nodes have no positive radius, first {}: estimated {how}",
            unknown.len(),
            self.ids[first as usize]
        ));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn coincident_isolated_and_unknown_are_mended() {
        let x = |x: f64| DVec3::new(x, 0.0, 0.0);
        let points = vec![x(0.0), x(1.0), x(1.0), x(2.0), x(9.0), x(3.0)];
        let radii = vec![0.0, f64::NAN, 0.5, 0.3, 1.0, 0.0];
        let net = CurveNet::new(points, radii, vec![[0, 1], [1, 2], [2, 3], [3, 5]]);
        let RepairedNet { net, warnings } = net.repaired(None).unwrap();
        assert_eq!(net.edges, [[0, 1], [1, 2], [2, 3]]);
        assert_eq!(net.radii, [0.5, 0.5, 0.3, 0.3]);
        assert_eq!(warnings.len(), 3, "{warnings:?}");
        assert!(net.repaired(None).unwrap().warnings.is_empty());
    }

    #[test]
    fn without_any_radius_the_lengths_decide() {
        let points = (0..3).map(|k| DVec3::X * f64::from(k)).collect();
        let net = CurveNet::new(points, vec![f64::NAN; 3], vec![[0, 1], [1, 2]]);
        let radii = net.repaired(None).unwrap().net.radii;
        assert!(radii.iter().all(|r| (r - SHARE).abs() < 1e-12));
        assert_eq!(net.repaired(Some(2.0)).unwrap().net.radii, [2.0; 3]);
    }

    #[test]
    fn a_net_without_length_is_refused() {
        let net = CurveNet::new(vec![DVec3::ONE; 2], vec![1.0; 2], vec![[0, 1]]);
        assert_eq!(net.repaired(None).unwrap_err().exit_code(), 3);
    }
}
