//! Nets of curves with radii: skeletons.
//!
//! | file | holds |
//! |---|---|
//! | `branches` | chains of segments between branchings and extremities |
//! | `builder` | nodes and links by the ids of a file, refused or noted |
//! | `merge` | branchings near each other become one |
//! | `repair` | what a method needs: no coincident nodes, no empty edges, radii everywhere |

mod branches;
mod builder;
mod merge;
mod net;
mod repair;

pub use branches::{Branch, Chains, branches};
pub use builder::NetBuilder;
pub use net::{CurveNet, Incidence};
pub use repair::RepairedNet;

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn net(nodes: usize, edges: &[[u32; 2]]) -> CurveNet {
        CurveNet::new((0..nodes).map(|k| DVec3::X * k as f64).collect(), vec![1.0; nodes], edges.to_vec())
    }

    #[test]
    fn cycles_count_per_component() {
        let mut n = net(8, &[[0, 1], [1, 2], [2, 0], [3, 4], [5, 6]]);
        assert_eq!(n.cycles(), [0, 0, 1]);
        assert_eq!(n.components().1, 4);
        n.edges.push([2, 1]);
        assert_eq!(n.drop_multiple_edges(), 1);
        n.retain_nodes(&[true, true, true, true, true, true, true, false]);
        assert_eq!((n.points.len(), n.cycles().len()), (7, 3));
        n.retain_nodes(&[true, false, true, true, true, true, true]);
        assert_eq!((n.points.len(), n.edges), (6, vec![[1, 0], [2, 3], [4, 5]]));
    }

    #[test]
    fn incidence_lists_every_edge_twice() {
        let n = net(4, &[[0, 1], [1, 2], [3, 1]]);
        let around = n.incidence();
        assert_eq!(around.of(1), [[0, 0], [1, 2], [2, 3]]);
        assert_eq!((0..4).map(|v| around.valence(v)).collect::<Vec<_>>(), [1, 3, 1, 1]);
    }
}
