//! The camera: where a point of the model appears in the image, and how near.

use super::content::{Path, Picture};
use super::view::{self, View};
use glam::DVec3;

/// Share of the image's half width or height that the model may fill.
const FILL: f64 = 0.93;

/// A point as the camera sees it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Seen {
    /// Samples from the left.
    pub(super) x: f64,
    /// Samples from the top.
    pub(super) y: f64,
    /// Grows towards the eye and is linear along straight lines in the image: the inverse of the distance, or the
    /// distance itself in a parallel projection.
    pub(super) nearness: f64,
}

/// A camera that sees the whole of a picture's model.
///
/// Points are first moved and scaled into a box of half side 1, so that neither 1e30 nor 1e-30 does harm.
pub(super) struct Camera {
    centre: DVec3,
    scale: f64,
    axes: [DVec3; 3],
    /// The eye, or any point of the line of sight through the middle of a parallel projection, in camera axes.
    eye: DVec3,
    /// Samples per unit: at distance 1, or everywhere in a parallel projection.
    zoom: f64,
    pub(super) parallel: bool,
    middle: [f64; 2],
}

impl Camera {
    /// A camera for an image of this many samples.
    pub(super) fn new(picture: &Picture<'_>, size: [usize; 2]) -> Self {
        let [width, height] = size.map(|s| s as f64);
        let points = drawn_points(picture);
        let (low, high) = bounds(points.iter().copied());
        let half = (high / 2.0 - low / 2.0).max_element();
        let mut camera = Camera {
            centre: low / 2.0 + high / 2.0,
            scale: if half > 0.0 { half } else { 1.0 },
            axes: axes(picture, &points),
            eye: DVec3::ZERO,
            zoom: 1.0,
            parallel: picture.field_of_view.is_nan() || picture.field_of_view <= 0.0,
            middle: [width / 2.0, height / 2.0],
        };
        if camera.parallel {
            camera.fit_parallel(&points);
        } else {
            let opening = picture.field_of_view.clamp(0.1, 120.0).to_radians();
            camera.zoom = width.min(height) / 2.0 / (opening / 2.0).tan();
            camera.fit_perspective(&points);
            camera.centre_image(&points);
        }
        camera
    }

    /// A point in a box of half side 1.
    pub(super) fn unit(&self, p: DVec3) -> DVec3 {
        (p - self.centre) / self.scale
    }

    /// A direction in camera axes: right, up, towards the eye.
    pub(super) fn turn(&self, d: DVec3) -> DVec3 {
        DVec3::from(self.axes.map(|axis| axis.dot(d)))
    }

    /// A point of the model in the image.
    pub(super) fn see(&self, p: DVec3) -> Seen {
        let q = self.turn(self.unit(p)) - self.eye;
        let nearness = if self.parallel { q.z } else { -1.0 / q.z };
        let zoom = if self.parallel { self.zoom } else { self.zoom * nearness };
        Seen { x: self.middle[0] + zoom * q.x, y: self.middle[1] - zoom * q.y, nearness }
    }

    fn fit_parallel(&mut self, points: &[DVec3]) {
        let (low, high) = bounds(points.iter().map(|&p| self.turn(self.unit(p))));
        self.eye = (low + high) / 2.0;
        let half = ((high - low) / 2.0).max(DVec3::splat(1e-6));
        self.zoom = FILL * (self.middle[0] / half.x).min(self.middle[1] / half.y);
    }

    /// Moves the eye so far back that all points lie between the four planes through it and the margins of the image.
    ///
    /// With `t` the slope of a plane, a point is inside on the right if x − eye.x ≤ t (eye.z − z), that is
    /// eye.x + t·eye.z ≥ x + t·z, on the left if −eye.x + t·eye.z ≥ −x + t·z; equality in both gives the eye.
    fn fit_perspective(&mut self, points: &[DVec3]) {
        let slopes = self.middle.map(|m| FILL * m / self.zoom);
        let mut reach = [[f64::NEG_INFINITY; 2]; 2];
        let mut nearest = 0f64;
        for p in points.iter().map(|&p| self.turn(self.unit(p))) {
            for (k, t) in slopes.into_iter().enumerate() {
                reach[k][0] = reach[k][0].max(p[k] + t * p.z);
                reach[k][1] = reach[k][1].max(t * p.z - p[k]);
            }
            nearest = nearest.max(p.z);
        }
        let fit = |k: usize| (reach[k][0] + reach[k][1]) / (2.0 * slopes[k]);
        let aside = |k: usize| (reach[k][0] - reach[k][1]) / 2.0;
        // Not closer than a quarter of the model's size, even if the model is a needle that points at the eye.
        let distance = [fit(0), fit(1), nearest + 0.5].into_iter().fold(1.0, f64::max);
        let [x, y] = [aside(0), aside(1)].map(|a| if a.is_finite() { a } else { 0.0 });
        self.eye = DVec3::new(x, y, distance);
    }

    /// Shifts the image, as a view camera does, so that equal margins are left on opposite sides.
    fn centre_image(&mut self, points: &[DVec3]) {
        let seen = points.iter().map(|&p| self.see(p)).map(|s| DVec3::new(s.x, s.y, 0.0));
        let (low, high) = bounds(seen);
        if low != high {
            let off = (low + high) / 2.0 - DVec3::new(self.middle[0], self.middle[1], 0.0);
            self.middle = [self.middle[0] - off.x, self.middle[1] - off.y];
        }
    }
}

/// All finite points that faces or lines use, each once.
fn drawn_points(picture: &Picture<'_>) -> Vec<DVec3> {
    let mut used = view::used_vertices(picture.points, picture.faces);
    let mut ends = Vec::new();
    for layer in &picture.lines {
        match layer.path {
            Path::Edges(edges) => edges.as_flattened().iter().for_each(|&v| view::mark(&mut used, v)),
            Path::Segments(segments) => ends.extend(segments.as_flattened().iter().filter(|p| p.is_finite())),
        }
    }
    ends.extend(picture.framed.iter().filter(|p| p.is_finite()));
    view::picked(picture.points, &used).chain(ends).collect()
}

/// Directions right, up and towards the eye. A view that is left open depends on the faces if there are any.
fn axes(picture: &Picture<'_>, drawn: &[DVec3]) -> [DVec3; 3] {
    match picture.view {
        View::Automatic if picture.faces.is_empty() => view::three_quarter(drawn.to_vec()).axes(),
        View::Automatic => View::automatic(picture.points, picture.faces).axes(),
        view => view.axes(),
    }
}

/// Smallest and largest coordinates; zero without points.
fn bounds(points: impl Iterator<Item = DVec3>) -> (DVec3, DVec3) {
    let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (low, high) = points.fold(start, |(l, h), p| (l.min(p), h.max(p)));
    if low.x <= high.x { (low, high) } else { (DVec3::ZERO, DVec3::ZERO) }
}
