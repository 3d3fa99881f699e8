//! Pictures: a mesh with coloured faces and lines, drawn to an image by a z-buffer on the CPU.
//!
//! The stages, in order, with the file of each:
//!
//! 1. `view`: from where to look, if the caller does not say;
//! 2. `camera`: the model is scaled to unit size and the camera moved back until everything fits;
//! 3. `scene`: polygons become triangles, with colours (`palette`) and normals split at creases (`normals`);
//! 4. `raster`: the image is drawn in bands of rows, each by itself: which triangle is nearest at every sample?
//! 5. `light`: the colour of every sample;
//! 6. `lines`: lines over it, tested against the depth of the faces;
//! 7. `image`: samples are averaged to pixels, pixels written as PNG.
//!
//! The bands do not depend on the number of threads, nor does the image.

mod camera;
mod color;
mod content;
mod edges;
mod image;
mod light;
mod lines;
mod normals;
mod palette;
mod raster;
mod scene;
#[cfg(test)]
mod tests;
mod tuning;
mod view;

use camera::Camera;
use rayon::prelude::*;
use scene::Scene;
use tuning::{BAND, SAMPLES};

pub use color::Rgb;
pub use content::{Colors, Lines, Path, Picture};
pub use edges::{border_edges, crease_edges, label_borders, mesh_edges};
pub use image::Image;
pub use palette::{Scale, label_color, label_colors, ramp_colors};
pub use view::View;

/// Draws a picture.
pub fn render(picture: &Picture<'_>) -> Image {
    let [width, height] = picture.size.map(|s| s.clamp(1, 16_384) as usize);
    let sampled = [width * SAMPLES, height * SAMPLES];
    let camera = Camera::new(picture, sampled);
    let scene = Scene::new(picture, &camera);
    let strokes = lines::strokes(picture, &camera);
    let apron = lines::apron(picture);
    let bands: Vec<usize> = (0..height).step_by(BAND).collect();
    let bins = raster::Bins::new(&scene, bands.len(), BAND * SAMPLES, apron);
    let rows: Vec<Vec<Rgb>> = bands
        .par_iter()
        .enumerate()
        .map(|(k, &first)| {
            let band = raster::Rows { first: first * SAMPLES, count: BAND.min(height - first) * SAMPLES, apron };
            let depth = raster::rasterise(&scene, bins.of(k), sampled, band);
            let mut colors = light::shade(&scene, &depth, color::linear(picture.background));
            lines::draw(&strokes, &depth, &mut colors);
            image::average(&colors, sampled[0], SAMPLES)
        })
        .collect();
    Image::new([width as u32, height as u32], rows.concat())
}
