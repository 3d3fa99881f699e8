//! Pictures of small scenes whose images are known.

use super::*;
use crate::context::Context;
use crate::mesh::Polygons;
use crate::sample;
use glam::DVec3;

const WHITE: Rgb = [255; 3];

/// A small picture, fast enough for many of them.
fn small<'a>(points: &'a [DVec3], faces: &'a Polygons) -> Picture<'a> {
    Picture { size: [240, 180], ..Picture::new(points, faces) }
}

fn from(eye: DVec3, up: DVec3) -> View {
    View::From { eye, up }
}

fn drawn(image: &Image) -> usize {
    image.pixels().iter().filter(|&&p| p != WHITE).count()
}

/// Pixels that clearly differ between two images.
fn differing(a: &Image, b: &Image) -> usize {
    let far = |p: &Rgb, q: &Rgb| p.iter().zip(q).any(|(x, y)| x.abs_diff(*y) > 8);
    a.pixels().iter().zip(b.pixels()).filter(|(p, q)| far(p, q)).count()
}

fn is_reddish([r, g, b]: Rgb) -> bool {
    u32::from(r) > u32::from(g) + 60 && u32::from(r) > u32::from(b) + 60
}

fn is_bluish([r, g, b]: Rgb) -> bool {
    u32::from(b) > u32::from(r) + 60 && u32::from(b) > u32::from(g) + 60
}

/// The square [−1, 1]² at this height, facing up.
fn square(z: f64) -> [DVec3; 4] {
    [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| DVec3::new(x, y, z))
}

fn cube() -> (Vec<DVec3>, Polygons) {
    let points = [-1.0, 1.0].into_iter().flat_map(square).collect();
    let faces = [[3, 2, 1, 0], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]];
    (points, faces.iter().map(|f: &[u32; 4]| &f[..]).collect())
}

#[test]
fn a_sphere_is_a_disc_without_cracks() {
    let mesh = sample::icosphere(5.0, 24).unwrap().mesh;
    for field_of_view in [0.0, 25.0, 70.0] {
        let image = render(&Picture { field_of_view, ..small(mesh.points(), mesh.faces()) });
        // The camera leaves 7 % of the height as margins.
        let radius = 0.93 * 90.0;
        let disc = std::f64::consts::PI * radius * radius;
        let share = drawn(&image) as f64 / disc;
        // Pixels on the rim count in full: about half a pixel too much all around.
        assert!((1.0..1.0 + 2.5 / radius).contains(&share), "{field_of_view}: {share}");
        for row in 0..180 {
            for column in 0..240 {
                let from_centre = (f64::from(column) + 0.5 - 120.0).hypot(f64::from(row) + 0.5 - 90.0);
                let pixel = image.pixel(column, row).unwrap();
                assert!(from_centre > radius - 1.5 || pixel[0] < 200, "hole at {column} {row}: {pixel:?}");
                assert!(from_centre < radius + 1.5 || pixel == WHITE, "{column} {row}: {pixel:?}");
            }
        }
    }
}

#[test]
fn the_nearer_face_hides_the_farther() {
    let points: Vec<DVec3> = [square(0.0), square(0.5).map(|p| p * DVec3::new(0.5, 0.5, 1.0))].concat();
    let colors: [Rgb; 2] = [[255, 0, 0], [0, 0, 255]];
    for order in [[0, 1], [1, 0]] {
        let faces: Polygons = order.iter().map(|&k| [&[0u32, 1, 2, 3][..], &[4, 5, 6, 7]][k]).collect();
        let colors = order.map(|k| colors[k]);
        let seen = |eye: DVec3| {
            let picture =
                Picture { view: from(eye, DVec3::Y), colors: Colors::Faces(&colors), ..small(&points, &faces) };
            render(&picture).pixel(120, 90).unwrap()
        };
        assert!(is_bluish(seen(DVec3::Z)));
        let below = seen(DVec3::NEG_Z);
        assert!(below[0] > below[2], "{below:?}");
    }
}

#[test]
fn faces_that_pass_through_each_other_are_cut_along_a_line() {
    // Two crossed planes seen along the bisector: left half one colour, right half the other.
    let points: Vec<DVec3> = [-1.0, 1.0]
        .into_iter()
        .flat_map(|s: f64| [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| DVec3::new(x, y, s * x)))
        .collect();
    let faces: Polygons = [&[0u32, 1, 2, 3][..], &[4, 5, 6, 7]].into_iter().collect();
    let picture = Picture {
        view: from(DVec3::Z, DVec3::Y),
        colors: Colors::Faces(&[[255, 0, 0], [0, 0, 255]]),
        ..small(&points, &faces)
    };
    let image = render(&picture);
    for row in 60..120 {
        // The first plane rises to the left (s = −1), the second to the right.
        assert!(is_reddish(image.pixel(112, row).unwrap()) && is_bluish(image.pixel(128, row).unwrap()));
    }
}

#[test]
fn backs_of_faces_are_darker_and_paler() {
    let points = square(0.0).to_vec();
    let faces: Polygons = [&[0u32, 1, 2, 3][..]].into_iter().collect();
    let seen = |eye| {
        let picture =
            Picture { view: from(eye, DVec3::Y), colors: Colors::Uniform([255, 60, 60]), ..small(&points, &faces) };
        render(&picture).pixel(120, 90).unwrap()
    };
    let ([front, back], spread) = ([DVec3::Z, DVec3::NEG_Z].map(seen), |c: Rgb| c[0] - c[1].min(c[2]));
    assert!(back[0] < front[0] && spread(back) < spread(front) / 2, "{front:?} {back:?}");
}

#[test]
fn creases_stay_sharp_and_smooth_edges_do_not() {
    let (points, faces) = cube();
    let colors_of = |crease: f64| {
        let image = render(&Picture { crease, ..small(&points, &faces) });
        let mut colors: Vec<Rgb> = image.pixels().to_vec();
        colors.sort_unstable();
        let groups = colors.chunk_by(|a, b| a == b).map(<[Rgb]>::len);
        // Colours of areas, not of pixels on edges.
        groups.filter(|&n| n > 1000).count()
    };
    assert_eq!(colors_of(35.0), 3 + 1, "three sides and the background");
    assert_eq!(colors_of(0.0), 3 + 1);
    assert_eq!(colors_of(120.0), 1, "rounded sides have no area of one colour");
}

#[test]
fn labels_that_meet_look_different_and_negative_ones_grey() {
    let side = 12;
    let points: Vec<DVec3> =
        (0..=side).flat_map(|y| (0..=side).map(move |x| DVec3::new(f64::from(x), f64::from(y), 0.0))).collect();
    let corner = |x: u32, y: u32| y * (side as u32 + 1) + x;
    let cells: Vec<[u32; 4]> = (0..side as u32)
        .flat_map(|y| {
            (0..side as u32).map(move |x| [corner(x, y), corner(x + 1, y), corner(x + 1, y + 1), corner(x, y + 1)])
        })
        .collect();
    let faces: Polygons = cells.iter().map(|c| &c[..]).collect();
    // A label per cell, scattered, so that neighbours have distant numbers.
    let labels: Vec<i32> = (0..side * side).map(|k| k * 89 % (side * side) * 1000).collect();
    let colors = label_colors(&faces, &labels);
    let lab = |c: Rgb| color::to_oklab(color::linear(c));
    for k in 0..colors.len() {
        for beside in [k + 1, k + side as usize].into_iter().filter(|b| *b < colors.len()) {
            if beside == k + 1 && beside % side as usize == 0 {
                continue;
            }
            let (a, b) = (lab(colors[k]), lab(colors[beside]));
            let distance = (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f32>().sqrt();
            assert!(distance > 0.1, "{k} {beside}: {distance}");
        }
    }
    assert_eq!(label_colors(&faces, &vec![-3; labels.len()]), vec![palette::MISSING; labels.len()]);
    let picture = Picture { view: from(DVec3::Z, DVec3::Y), colors: Colors::Labels(&labels), ..small(&points, &faces) };
    let image = render(&picture);
    let lit = |column, row| image.pixel(column, row).unwrap();
    assert_ne!(lit(70, 90), lit(84, 90));
}

#[test]
fn consecutive_label_colors_differ() {
    let lab = |k| color::to_oklab(color::linear(label_color(k)));
    for k in 0..24 {
        let (a, b) = (lab(k), lab(k + 1));
        let distance = (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f32>().sqrt();
        assert!(distance > 0.12, "{k}: {distance}");
    }
}

#[test]
fn scales_are_monotone_in_lightness_and_show_what_is_missing() {
    let lightness = |ramp: &palette::Ramp, x: f32| color::to_oklab(ramp.at(x))[0];
    let steps: Vec<f32> = (0..=100).map(|k| k as f32 / 100.0).collect();
    let sequential = palette::Ramp::new(Scale::Sequential(None));
    assert!(steps.windows(2).all(|w| lightness(&sequential, w[0]) < lightness(&sequential, w[1])));
    let diverging = palette::Ramp::new(Scale::Diverging(None));
    assert!(steps.windows(2).all(|w| (lightness(&diverging, w[0]) < lightness(&diverging, w[1])) == (w[1] <= 0.5)));
    assert_eq!(Scale::Sequential(None).places(&[-2.0, 3.0, 0.5]), [0.0, 1.0, 0.5]);
    assert_eq!(Scale::Sequential(Some([0.0, 1.0])).places(&[-2.0, 3.0, 0.25]), [0.0, 1.0, 0.25]);
    assert_eq!(Scale::Diverging(None).places(&[-4.0, 0.0, 2.0]), [0.0, 0.5, 0.75]);
    assert_eq!(Scale::Sequential(None).places(&[7.0, 7.0]), [0.5, 0.5]);
    assert_eq!(Scale::Sequential(None).places(&[-1e308, 1e308]), [0.0, 1.0]);
    assert!(Scale::Sequential(None).places(&[f64::NAN, 1.0])[0].is_nan());
    assert_eq!(color::encode(sequential.at(f32::NAN)), palette::MISSING);
}

#[test]
fn numbers_on_vertices_are_interpolated() {
    let points = square(0.0).to_vec();
    let faces: Polygons = [&[0u32, 1, 2, 3][..]].into_iter().collect();
    let picture = Picture {
        view: from(DVec3::Z, DVec3::Y),
        colors: Colors::VertexScalars(&[0.0, 1.0, 1.0, 0.0], Scale::Sequential(None)),
        ..small(&points, &faces)
    };
    let image = render(&picture);
    let green = |column| u32::from(image.pixel(column, 90).unwrap()[1]);
    assert!((50..190).step_by(20).all(|c| green(c) < green(c + 20)));
}

/// A face in the middle and a segment through the image, in front of it or behind.
fn with_line(z: f64, change: impl Fn(&mut Lines<'_>)) -> Image {
    let points = square(0.0).to_vec();
    let faces: Polygons = [&[0u32, 1, 2, 3][..]].into_iter().collect();
    let segments = [[DVec3::new(-2.0, 0.0, z), DVec3::new(2.0, 0.0, z)]];
    let mut lines = Lines::new(Path::Segments(&segments), [255, 0, 0], 5.0);
    change(&mut lines);
    render(&Picture {
        view: from(DVec3::Z, DVec3::Y),
        field_of_view: 0.0,
        lines: vec![lines],
        ..small(&points, &faces)
    })
}

#[test]
fn lines_have_their_width_and_colour() {
    for z in [0.5, 0.0] {
        let image = with_line(z, |_| {});
        for column in [20, 60, 120, 200] {
            let red = (0..180).filter(|&row| is_reddish(image.pixel(column, row).unwrap())).count();
            assert!((5..=6).contains(&red), "{z}, column {column}: {red}");
        }
    }
    let faint = with_line(0.5, |l| l.opacity = 0.5).pixel(60, 90).unwrap();
    assert!(faint[0] > faint[1] && faint[1] > 60, "{faint:?}");
    assert_eq!(with_line(0.5, |l| l.opacity = 0.0), with_line(0.5, |l| l.width = 0.0));
}

#[test]
fn faces_hide_lines_behind_them_unless_told_otherwise() {
    let red = |image: &Image, column| (0..180).any(|row| is_reddish(image.pixel(column, row).unwrap()));
    let behind = with_line(-0.5, |_| {});
    assert!(red(&behind, 15) && !red(&behind, 120) && red(&behind, 225));
    let through = with_line(-0.5, |l| l.hidden = false);
    assert!((10..230).all(|column| red(&through, column)));
}

#[test]
fn the_edges_in_view_of_a_cube_are_drawn_and_the_others_hidden() {
    let (points, faces) = cube();
    let edges = mesh_edges(points.len(), &faces);
    assert_eq!(edges.len(), 12);
    let view = from(DVec3::new(0.5, -1.0, 0.4), DVec3::Z);
    let red = |edges: &[[u32; 2]]| {
        let lines = vec![Lines::new(Path::Edges(edges), [255, 0, 0], 3.0)];
        let image = render(&Picture { view, lines, ..small(&points, &faces) });
        image.pixels().iter().filter(|&&p| is_reddish(p)).count()
    };
    // The eye sees the sides −y, +x and +z: all edges but the three at the corner (−1, 1, −1), number 3.
    let (hidden, shown): (Vec<_>, Vec<_>) = edges.into_iter().partition(|e| e.contains(&3));
    for edge in shown {
        assert!(red(&[edge]) > 60, "{edge:?}: {}", red(&[edge]));
    }
    // Their ends stand out a little at the silhouette.
    assert!(red(&hidden) < 60, "{}", red(&hidden));
}

#[test]
fn dots_are_round() {
    let points = [DVec3::new(-1.0, 0.0, 0.0), DVec3::new(1.0, 0.0, 0.0)];
    let dot = [[DVec3::ZERO, DVec3::ZERO]];
    let frame = [points];
    let lines =
        vec![Lines::new(Path::Segments(&frame), WHITE, 0.0), Lines::new(Path::Segments(&dot), [255, 0, 0], 40.0)];
    let empty = Polygons::new();
    let image = render(&Picture { lines, ..small(&[], &empty) });
    let area = drawn(&image) as f64 / (std::f64::consts::PI * 400.0);
    assert!((1.0..1.12).contains(&area), "{area}");
}

#[test]
fn edges_worth_drawing() {
    let (points, faces) = cube();
    assert_eq!(crease_edges(&points, &faces, 80.0).len(), 12);
    assert_eq!(crease_edges(&points, &faces, 100.0).len(), 0);
    assert_eq!(border_edges(points.len(), &faces).len(), 0);
    assert_eq!(label_borders(points.len(), &faces, &[0, 1, 1, 1, 1, 1]).len(), 4);
    let open: Polygons = faces.iter().skip(1).collect();
    assert_eq!(border_edges(points.len(), &open).len(), 4);
    assert_eq!(label_borders(points.len(), &open, &[5; 5]).len(), 4);
}

#[test]
fn the_image_does_not_depend_on_the_scale_of_the_model() {
    let mesh = sample::make("bracket", Some(30), &Context::new()).unwrap();
    let image = |scale: f64, shift: DVec3| {
        let points: Vec<DVec3> = mesh.points().iter().map(|&p| p * scale + shift).collect();
        let edges = crease_edges(&points, mesh.faces(), 40.0);
        render(&Picture { lines: vec![Lines::bold(Path::Edges(&edges))], ..small(&points, mesh.faces()) })
    };
    let plain = image(1.0, DVec3::ZERO);
    assert!(drawn(&plain) > 8000);
    assert_eq!(plain, image(1024.0, DVec3::ZERO), "by a power of two nothing is rounded differently");
    for (scale, shift) in [(1e30, 0.0), (1e-30, 0.0), (1e300, 0.0), (1e-300, 0.0), (0.37, 500.0)] {
        let other = image(scale, DVec3::splat(shift));
        let differ = differing(&plain, &other);
        assert!(differ < 40, "{scale}: {differ} pixels differ");
    }
}

#[test]
fn the_image_does_not_depend_on_the_number_of_threads() {
    let mesh = sample::make("tube-tree", Some(60), &Context::new()).unwrap();
    let edges = mesh_edges(mesh.vertex_count(), mesh.faces());
    let picture = || Picture { lines: vec![Lines::fine(Path::Edges(&edges))], ..small(mesh.points(), mesh.faces()) };
    let [one, three] = [1, 3].map(|n| Context::new().with_threads(n).unwrap().install(|| render(&picture())));
    assert_eq!(one, three);
}

#[test]
fn png_files_hold_the_pixels() {
    let (points, faces) = cube();
    let image = render(&small(&points, &faces));
    let bytes = image.to_png().unwrap();
    let mut reader = png::Decoder::new(std::io::Cursor::new(&bytes)).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    assert_eq!((info.width, info.height, info.color_type), (240, 180, png::ColorType::Rgb));
    assert_eq!(pixels, image.pixels().as_flattened());
    assert!(Image::beside(&[], WHITE).to_png().is_err());
}

#[test]
fn images_stand_side_by_side() {
    let (points, faces) = cube();
    let large = render(&small(&points, &faces));
    let little = render(&Picture { size: [40, 30], background: [9, 8, 7], ..small(&points, &faces) });
    let both = Image::beside(&[large.clone(), little.clone()], [1, 2, 3]);
    assert_eq!((both.width(), both.height()), (280, 180));
    assert_eq!(both.pixel(100, 100), large.pixel(100, 100));
    assert_eq!(both.pixel(260, 15), little.pixel(20, 15));
    assert_eq!((both.pixel(240, 0), both.pixel(260, 100)), (Some([9, 8, 7]), Some([1, 2, 3])));
}

#[test]
fn scans_stand_on_y_and_parts_on_z() {
    let cone = |up: fn(f64, f64, f64) -> DVec3| {
        let ring = (0..16).map(|k| f64::from(k) * std::f64::consts::TAU / 16.0).map(|a| up(a.cos(), a.sin(), 0.0));
        let points: Vec<DVec3> = ring.chain([up(0.0, 0.0, 2.0)]).collect();
        let faces: Vec<[u32; 3]> = (0..16).map(|k| [k, (k + 1) % 16, 16]).collect();
        match View::automatic(&points, &Polygons::from_triangles(&faces)) {
            View::From { up, .. } => up,
            View::Automatic => DVec3::NAN,
        }
    };
    assert_eq!(cone(|a, b, height| DVec3::new(a, height, b)), DVec3::Y);
    assert_eq!(cone(DVec3::new), DVec3::Z);
}

#[test]
fn nothing_to_draw_is_background() {
    let no_faces = Polygons::new();
    let blank = |picture: &Picture<'_>| {
        let image = render(picture);
        assert_eq!(drawn(&image), 0);
    };
    blank(&small(&[], &no_faces));
    blank(&small(&[DVec3::X], &no_faces));
    let points = vec![DVec3::X; 3];
    blank(&small(&points, &Polygons::from_triangles(&[[0, 1, 2]])));
    let line = vec![DVec3::ZERO, DVec3::X, DVec3::X * 2.0];
    blank(&small(&line, &Polygons::from_triangles(&[[0, 1, 2]])));
    let size = render(&Picture { size: [0, 0], ..small(&[], &no_faces) });
    assert_eq!((size.width(), size.height()), (1, 1));
}

#[test]
fn what_is_wrong_is_left_out() {
    let (mut points, faces) = cube();
    let whole = render(&small(&points, &faces));
    points.extend([DVec3::NAN, DVec3::INFINITY, DVec3::splat(1e300)]);
    let mut wrong = faces.clone();
    for face in [[0, 1, 8], [0, 9, 2], [0, 1, u32::MAX], [99, 100, 101]] {
        wrong.push(&face);
    }
    wrong.push(&[0]);
    let segments = [[DVec3::NAN, DVec3::X], [DVec3::X, DVec3::INFINITY]];
    let lines = vec![
        Lines::bold(Path::Edges(&[[0, 8], [0, 77], [u32::MAX, 1]])),
        Lines::new(Path::Segments(&segments), [0; 3], f64::NAN),
    ];
    let image = render(&Picture { lines, ..small(&points, &wrong) });
    assert_eq!(differing(&whole, &image), 0);
    for colors in [
        Colors::Labels(&[1]),
        Colors::Faces(&[]),
        Colors::FaceScalars(&[f64::NAN], Scale::Diverging(Some(f64::NAN))),
        Colors::VertexScalars(&[1.0], Scale::Sequential(Some([1.0, -1.0]))),
    ] {
        for (field_of_view, crease) in [(f64::NAN, f64::NAN), (1e-300, 1e300), (f64::INFINITY, -1.0)] {
            let image = render(&Picture { colors, field_of_view, crease, ..small(&points, &wrong) });
            assert!(drawn(&image) > 1000);
        }
    }
    for view in [from(DVec3::ZERO, DVec3::Z), from(DVec3::NAN, DVec3::NAN), from(DVec3::Z, DVec3::Z)] {
        assert!(drawn(&render(&Picture { view, ..small(&points, &faces) })) > 1000);
    }
}
