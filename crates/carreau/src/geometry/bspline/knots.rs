//! Knot vectors and the basis functions they define.

use crate::error::{Error, Result};

/// The largest degree, so that basis functions fit small arrays.
pub const MAX_DEGREE: usize = 3;

/// Values of the `degree + 1` basis functions that do not vanish at a parameter; unused places are zero.
pub type Basis = [f64; MAX_DEGREE + 1];

/// A clamped knot vector: non-decreasing, the first and the last value `degree + 1` times, inner values at most `degree`
/// times (the spline is continuous).
#[derive(Debug, Clone, PartialEq)]
pub struct Knots {
    degree: usize,
    values: Vec<f64>,
}

impl Knots {
    /// Checks a full knot vector.
    ///
    /// # Errors
    /// [`Error::Input`] for knots that are no knot vector.
    pub fn new(degree: usize, values: Vec<f64>) -> Result<Self> {
        let wrong = |what: &str| Err(Error::input(format!("a knot vector {what}"), "", ""));
        if !(1..=MAX_DEGREE).contains(&degree) {
            return wrong("has a degree outside 1..=3");
        }
        let order = degree + 1;
        if values.len() < 2 * order || values.iter().any(|t| !t.is_finite()) {
            return wrong("is too short or not finite");
        }
        if values.windows(2).any(|w| w[0] > w[1]) {
            return wrong("decreases");
        }
        let (first, last) = (values[0], values[values.len() - 1]);
        let multiplicities = || values.chunk_by(|a, b| a == b);
        let ends = multiplicities().filter(|c| c[0] == first || c[0] == last).all(|c| c.len() == order);
        let inner = multiplicities().filter(|c| c[0] != first && c[0] != last).all(|c| c.len() <= degree);
        if first == last || !ends || !inner {
            return wrong("is not clamped or has an inner knot of too high a multiplicity");
        }
        Ok(Knots { degree, values })
    }

    /// Knots at these strictly increasing break points (two at least), inner ones `multiplicity` times.
    ///
    /// # Errors
    /// As [`Knots::new`].
    pub fn from_breaks(degree: usize, breaks: &[f64], multiplicity: usize) -> Result<Self> {
        let last = breaks.len().saturating_sub(1);
        let times = |k: usize| if k == 0 || k == last { degree + 1 } else { multiplicity };
        Self::new(degree, breaks.iter().enumerate().flat_map(|(k, &t)| std::iter::repeat_n(t, times(k))).collect())
    }

    /// Degree 1 with knots 0, 1, …, `spans`: parameters are indices of control points.
    pub fn index(spans: u32) -> Self {
        let mut values = Vec::with_capacity(spans as usize + 3);
        values.push(0.0);
        values.extend((0..=spans.max(1)).map(f64::from));
        values.push(f64::from(spans.max(1)));
        Knots { degree: 1, values }
    }

    /// The degree.
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// All knots, with repetitions.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Number of basis functions, that is of control points.
    pub fn count(&self) -> usize {
        self.values.len() - self.degree - 1
    }

    /// First and last parameter.
    pub fn domain(&self) -> [f64; 2] {
        [self.values[0], self.values[self.values.len() - 1]]
    }

    /// Distinct knots with their multiplicities, increasing.
    pub fn distinct(&self) -> impl Iterator<Item = (f64, usize)> + '_ {
        self.values.chunk_by(|a, b| a == b).map(|c| (c[0], c.len()))
    }

    /// Distinct knots, increasing.
    pub fn breaks(&self) -> Vec<f64> {
        self.distinct().map(|(t, _)| t).collect()
    }

    /// How often a value occurs.
    pub fn multiplicity(&self, t: f64) -> usize {
        self.values.partition_point(|&k| k <= t) - self.values.partition_point(|&k| k < t)
    }

    /// The span `k` with `values[k] <= t < values[k + 1]`, the last one for the end of the domain; parameters outside
    /// the domain count as its nearest end.
    #[inline]
    pub fn span(&self, t: f64) -> usize {
        self.values.partition_point(|&k| k <= t).saturating_sub(1).clamp(self.degree, self.count() - 1)
    }

    /// The first basis function that does not vanish at `t`, and the values from there on (algorithm A2.2).
    #[inline]
    pub fn basis(&self, t: f64) -> (usize, Basis) {
        let span = self.span(t);
        (span - self.degree, self.basis_in(span, self.degree, t))
    }

    /// Values, first and second derivatives of the basis functions (eq. 2.7, applied twice).
    #[inline]
    pub fn derivatives(&self, t: f64) -> (usize, [Basis; 3]) {
        let (span, p) = (self.span(t), self.degree);
        // From one degree to the next, the two before the last are kept.
        let mut lower = [Basis::default(); 2];
        let mut n = Basis::default();
        n[0] = 1.0;
        for d in 1..=p {
            lower = [lower[1], n];
            self.raise(span, d, t, &mut n);
        }
        let first = self.derived(span, p, &lower[1]);
        let second = match p {
            1 => Basis::default(),
            _ => self.derived(span, p, &self.derived(span, p - 1, &lower[0])),
        };
        (span - p, [n, first, second])
    }

    /// Basis functions of a lower or equal degree on the same knots.
    #[inline]
    fn basis_in(&self, span: usize, degree: usize, t: f64) -> Basis {
        let mut n = Basis::default();
        n[0] = 1.0;
        (1..=degree).for_each(|d| self.raise(span, d, t, &mut n));
        n
    }

    /// Basis functions of degree d from those of the degree before.
    #[inline]
    fn raise(&self, span: usize, d: usize, t: f64, n: &mut Basis) {
        let near = &self.values[span + 1 - d..=span + d];
        let mut saved = 0.0;
        for (r, value) in n.iter_mut().enumerate().take(d) {
            let (right, left) = (near[d + r], near[r]);
            let part = *value / (right - left);
            *value = saved + (right - t) * part;
            saved = (t - left) * part;
        }
        n[d] = saved;
    }

    /// Coefficients on the basis of degree `d − 1` as a derivative on the basis of degree `d`:
    /// N'(i,d) = d N(i,d−1) / (u(i+d) − u(i)) − d N(i+1,d−1) / (u(i+d+1) − u(i+1)).
    fn derived(&self, span: usize, d: usize, lower: &Basis) -> Basis {
        let mut out = Basis::default();
        for j in 0..d {
            let i = span - d + 1 + j;
            let slope = d as f64 * lower[j] / (self.values[i + d] - self.values[i]);
            out[j] -= slope;
            out[j + 1] += slope;
        }
        out
    }

    /// The same knots over another domain.
    pub fn rescaled(&self, domain: [f64; 2]) -> Self {
        let [a, b] = self.domain();
        let affine = |t: f64| match t {
            t if t == a => domain[0],
            t if t == b => domain[1],
            t => domain[0] + (t - a) / (b - a) * (domain[1] - domain[0]),
        };
        Knots { degree: self.degree, values: self.values.iter().map(|&t| affine(t)).collect() }
    }

    /// The knots run backwards over the same domain.
    pub fn reversed(&self) -> Self {
        let [a, b] = self.domain();
        let mirror = |t: f64| match t {
            t if t == a => b,
            t if t == b => a,
            t => a + (b - t),
        };
        Knots { degree: self.degree, values: self.values.iter().rev().map(|&t| mirror(t)).collect() }
    }

    /// The knots with `t` once more.
    pub(super) fn with(&self, t: f64) -> Self {
        let mut values = self.values.clone();
        values.insert(self.span(t) + 1, t);
        Knots { degree: self.degree, values }
    }

    /// The smallest knot vector that has both: every value as often as in the one that has it more often. Degrees and
    /// domains must agree.
    pub fn union(&self, other: &Knots) -> Self {
        let (a, b) = (&self.values, &other.values);
        let mut values = Vec::with_capacity(a.len().max(b.len()));
        let (mut i, mut j) = (0, 0);
        while i < a.len() || j < b.len() {
            let next = match (a.get(i), b.get(j)) {
                (Some(&x), Some(&y)) => x.min(y),
                (Some(&x), None) | (None, Some(&x)) => x,
                (None, None) => break,
            };
            values.push(next);
            i += usize::from(a.get(i) == Some(&next));
            j += usize::from(b.get(j) == Some(&next));
        }
        Knots { degree: self.degree, values }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A random valid knot vector.
    pub(super) fn knots() -> impl Strategy<Value = Knots> {
        (1..=MAX_DEGREE, prop::collection::vec((0.05f64..1.0, 1usize..4), 1..8)).prop_map(|(degree, steps)| {
            let mut values = vec![0.0; degree + 1];
            let mut t = 0.0;
            let last = steps.len() - 1;
            for (k, (step, times)) in steps.into_iter().enumerate() {
                t += step;
                values.extend(std::iter::repeat_n(t, if k == last { degree + 1 } else { times.min(degree) }));
            }
            Knots::new(degree, values).unwrap()
        })
    }

    proptest! {
        #[test]
        fn basis_is_a_partition_of_unity_with_consistent_derivatives(k in knots(), s in 0.0f64..=1.0) {
            let t = s * k.domain()[1];
            let (first, [n, d, dd]) = k.derivatives(t);
            prop_assert_eq!(k.basis(t), (first, n));
            prop_assert!(first + k.degree() < k.count());
            prop_assert!(n.iter().all(|&x| x >= -1e-14));
            let scale = d.iter().chain(&dd).fold(1.0f64, |m, x| m.max(x.abs()));
            prop_assert!((n.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            prop_assert!(d.iter().sum::<f64>().abs() < 1e-12 * scale && dd.iter().sum::<f64>().abs() < 1e-11 * scale);
            // Differences inside the span.
            let (a, b) = (k.values()[first + k.degree()], k.values()[first + k.degree() + 1]);
            let h = 1e-4 * (b - a);
            let x = t.clamp(a + h, b - h);
            let (_, [_, d, dd]) = k.derivatives(x);
            let (low, high) = (k.basis(x - h).1, k.basis(x + h * 0.999_999).1);
            let mid = k.basis(x).1;
            for j in 0..=k.degree() {
                let scale = 1.0 / (b - a);
                prop_assert!(((high[j] - low[j]) / (2.0 * h) - d[j]).abs() < 1e-3 * scale);
                prop_assert!(((high[j] - 2.0 * mid[j] + low[j]) / (h * h) - dd[j]).abs() < 0.2 * scale * scale);
            }
        }

        #[test]
        fn union_contains_both(a in knots(), b in knots()) {
            let b = b.rescaled(a.domain());
            let both = a.union(&Knots { degree: a.degree, values: b.values.clone() });
            for (t, m) in a.distinct().chain(b.distinct()) {
                prop_assert!(both.multiplicity(t) >= m);
            }
            prop_assert!(both.values.windows(2).all(|w| w[0] <= w[1]));
        }
    }

    #[test]
    fn wrong_knots_are_refused() {
        for (degree, values) in [
            (0, vec![0.0, 1.0]),
            (4, vec![0.0; 10]),
            (1, vec![0.0, 0.0, 1.0]),
            (1, vec![0.0, 0.0, 0.0, 0.0]),
            (1, vec![0.0, 0.0, f64::NAN, 1.0, 1.0]),
            (1, vec![0.0, 0.0, 2.0, 1.0, 1.0]),
            (1, vec![0.0, 0.0, 1.0, 1.0, 2.0, 2.0]),
            (2, vec![0.0, 0.0, 1.0, 1.0, 1.0]),
        ] {
            assert!(Knots::new(degree, values.clone()).is_err(), "{degree} {values:?}");
        }
        assert_eq!(Knots::index(3).values(), [0.0, 0.0, 1.0, 2.0, 3.0, 3.0]);
        assert_eq!(Knots::index(3).count(), 4);
    }
}
