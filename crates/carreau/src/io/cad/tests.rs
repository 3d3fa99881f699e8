//! Breaks, numbers and dates of CAD files.

use super::breaks::has_breaks;
use super::*;
use crate::geometry::bspline::{BSplineSurface, Knots};
use glam::DVec3;

/// A strip of two cells, folded by an angle along the middle.
fn folded(degrees: f64) -> BSplineSurface {
    let fold = degrees.to_radians();
    let points =
        [0.0, 1.0].map(|y| [DVec3::new(-1.0, y, 0.0), DVec3::new(0.0, y, 0.0), DVec3::new(fold.cos(), y, fold.sin())]);
    BSplineSurface::new(Knots::index(2), Knots::index(1), points.as_flattened().to_vec()).unwrap()
}

/// A flat strip of two cells with these widths.
fn flat(widths: [f64; 2]) -> BSplineSurface {
    let points = [0.0, 1.0].map(|y| [-widths[0], 0.0, widths[1]].map(|x| DVec3::new(x, y, 0.0)));
    BSplineSurface::new(Knots::index(2), Knots::index(1), points.as_flattened().to_vec()).unwrap()
}

/// The same with rows for columns.
fn turned(s: &BSplineSurface) -> BSplineSurface {
    let [u, v] = s.knots();
    let points = (0..u.count()).flat_map(|c| (0..v.count()).map(move |r| s.control(c, r))).collect();
    BSplineSurface::new(v.clone(), u.clone(), points).unwrap()
}

#[test]
fn breaks_are_bends_and_changes_of_width_across_grid_lines() {
    let broken = |s: BSplineSurface| {
        let either = [has_breaks(&s), has_breaks(&turned(&s))];
        assert_eq!(either[0], either[1]);
        either[0]
    };
    assert!(!broken(folded(0.0)) && !broken(folded(2.0)));
    assert!(broken(folded(4.0)) && broken(folded(90.0)) && broken(folded(180.0)));
    assert!(!broken(flat([1.0, 1.04])) && broken(flat([1.0, 1.1])) && broken(flat([1.0, 0.0])));
    assert!(!broken(flat([0.0, 0.0])));
}

#[test]
fn reals_have_a_point_and_read_back() {
    let text = |x: f64| {
        let mut out = Vec::new();
        push_real(&mut out, x, b'E');
        String::from_utf8(out).unwrap()
    };
    assert_eq!([1.0, 0.1, -0.0, 1e-7, 1.5e-7, 1e300].map(text), ["1.", "0.1", "-0.", "1.E-7", "1.5E-7", "1.E300"]);
    for x in [0.1 + 0.2, f64::MAX, f64::MIN_POSITIVE, 5e-324, -123456789.123] {
        assert!(text(x).contains('.'));
        assert_eq!(text(x).parse::<f64>().unwrap().to_bits(), x.to_bits());
    }
}

#[test]
fn dates_are_checked() {
    let with = |date: &str| CadOptions { date: date.into(), ..Default::default() }.check().is_ok();
    assert!(CadOptions::default().check().is_ok() && with("2024-02-29T12:00:00"));
    assert!(!with("") && !with("2024-02-29") && !with("2024-02-29 12:00:00") && !with("2024-02-29T12:00:0x"));
}
