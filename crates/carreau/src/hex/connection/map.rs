//! Planar maps: graphs drawn on the sphere, double edges allowed, as rotation systems.
//!
//! Half-edges 2e and 2e + 1 are the two directions of edge e. Every vertex lists the half-edges that leave it,
//! counter-clockwise seen from outside; faces follow from that. Valence 2 in the dual makes double edges, so an edge is
//! never named by its ends.

/// A graph on the sphere.
#[derive(Debug, Clone)]
pub struct Map {
    /// Vertex that each half-edge leaves.
    pub origin: Vec<u32>,
    /// Half-edges that leave each vertex, counter-clockwise.
    pub around: Vec<Vec<u32>>,
}

impl Map {
    /// The map of triangles that close up, counter-clockwise; `None` where they do not.
    pub fn of_triangles(vertices: usize, triangles: &[[u32; 3]]) -> Option<Map> {
        let mut edges: Vec<[u32; 2]> = Vec::new();
        let sides = || triangles.iter().flat_map(|t| (0..3).map(|k| [t[k], t[(k + 1) % 3]]));
        sides().filter(|[a, b]| a < b).for_each(|e| edges.push(e));
        let half = |a: u32, b: u32| {
            let e = edges.iter().position(|&e| e == [a.min(b), a.max(b)])? as u32;
            Some(2 * e + u32::from(a > b))
        };
        let mut around = vec![Vec::new(); vertices];
        for v in 0..vertices as u32 {
            // In the triangle (v, a, b) the edge to b follows the edge to a.
            let fan: Vec<[u32; 2]> = triangles
                .iter()
                .filter_map(|t| {
                    let k = t.iter().position(|&w| w == v)?;
                    Some([t[(k + 1) % 3], t[(k + 2) % 3]])
                })
                .collect();
            let mut next = fan.first()?[0];
            for _ in 0..fan.len() {
                around[v as usize].push(half(v, next)?);
                next = fan.iter().find(|f| f[0] == next)?[1];
            }
            if next != fan[0][0] {
                return None;
            }
        }
        let origin = edges.iter().flatten().copied().collect();
        Some(Map { origin, around })
    }

    /// The vertex that a half-edge leads to.
    pub fn head(&self, h: u32) -> u32 {
        self.origin[(h ^ 1) as usize]
    }

    /// Number of edges at a vertex.
    pub fn valence(&self, v: u32) -> usize {
        self.around[v as usize].len()
    }

    fn place(&self, h: u32) -> usize {
        self.around[self.origin[h as usize] as usize].iter().position(|&x| x == h).unwrap_or(0)
    }

    /// The half-edge that leaves the same vertex, `by` places on counter-clockwise.
    pub fn turned(&self, h: u32, by: isize) -> u32 {
        let list = &self.around[self.origin[h as usize] as usize];
        list[(self.place(h) as isize + by).rem_euclid(list.len() as isize) as usize]
    }

    /// The next half-edge around the face on the left.
    pub fn next(&self, h: u32) -> u32 {
        self.turned(h ^ 1, -1)
    }

    /// The half-edges around the face on the left of one.
    pub fn face(&self, h: u32) -> Vec<u32> {
        let mut face = vec![h];
        let mut next = self.next(h);
        while next != h && face.len() <= self.origin.len() {
            face.push(next);
            next = self.next(next);
        }
        face
    }

    /// All half-edges that are there.
    pub fn half_edges(&self) -> impl Iterator<Item = u32> + '_ {
        self.around.iter().flatten().copied()
    }

    /// All edges, by their even half-edges.
    pub fn edges(&self) -> Vec<u32> {
        let mut edges: Vec<u32> = self.half_edges().filter(|h| h % 2 == 0).collect();
        edges.sort_unstable();
        edges
    }

    /// Takes an edge out: its two faces become one.
    pub fn remove(&mut self, h: u32) {
        for h in [h, h ^ 1] {
            let at = self.place(h);
            self.around[self.origin[h as usize] as usize].remove(at);
        }
    }

    /// Cuts a face by an edge between the corners before two of its half-edges; returns the half-edge that leaves the
    /// first.
    ///
    /// ```text
    ///   ←──b──•          the new edge leaves each vertex just after the face's own half-edge there
    ///   │    ╱│          in counter-clockwise order
    ///   │  ╱  │
    ///   •──a──→
    /// ```
    pub fn cut(&mut self, a: u32, b: u32) -> u32 {
        let new = self.origin.len() as u32;
        let (from, to) = (self.origin[a as usize], self.origin[b as usize]);
        self.origin.extend([from, to]);
        for (at, h) in [(a, new), (b, new + 1)] {
            let place = self.place(at) + 1;
            self.around[self.origin[at as usize] as usize].insert(place, h);
        }
        new
    }

    /// Doubles an edge: a face of two sides comes to lie on the left of the half-edge.
    pub fn double(&mut self, h: u32) -> u32 {
        let new = self.origin.len() as u32;
        let (from, to) = (self.origin[h as usize], self.head(h));
        self.origin.extend([from, to]);
        let at = self.place(h) + 1;
        self.around[from as usize].insert(at, new);
        let at = self.place(h ^ 1);
        self.around[to as usize].insert(at, new + 1);
        new
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn faces(map: &Map) -> usize {
        let mut seen = vec![false; map.origin.len()];
        let mut count = 0;
        for h in map.half_edges().collect::<Vec<_>>() {
            if !seen[h as usize] {
                count += 1;
                map.face(h).into_iter().for_each(|f| seen[f as usize] = true);
            }
        }
        count
    }

    /// Vertices − edges + faces = 2 through every change.
    #[test]
    fn changes_keep_eulers_formula() {
        let octahedron = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1], [5, 2, 1], [5, 3, 2], [5, 4, 3], [5, 1, 4]];
        let mut map = Map::of_triangles(6, &octahedron).unwrap();
        let euler = |map: &Map| 6 + faces(map) as isize - map.edges().len() as isize;
        assert_eq!((faces(&map), euler(&map)), (8, 2));
        let h = map.around[0][0];
        let face = map.face(h);
        assert_eq!(face.len(), 3);
        map.remove(h);
        assert_eq!((faces(&map), euler(&map)), (7, 2));
        let quad = map.half_edges().find(|&h| map.face(h).len() == 4).unwrap();
        let quad = map.face(quad);
        let new = map.cut(quad[0], quad[2]);
        assert_eq!((faces(&map), euler(&map), map.face(new).len(), map.face(new ^ 1).len()), (8, 2, 3, 3));
        let twin = map.double(new);
        assert_eq!((faces(&map), euler(&map)), (9, 2));
        assert!(map.face(new).len() == 2 || map.face(twin).len() == 2 || map.face(twin ^ 1).len() == 2);
    }
}
