//! What to do about files that are not read.

/// What to do about a file of a format that is not read.
pub fn advice(extension: &str) -> Option<&'static str> {
    Some(match extension {
        "step" | "stp" | "iges" | "igs" => {
            "it holds exact faces, not a mesh, and is written only; mesh it first, with Gmsh (`gmsh IN -2 -o OUT.stl`) or FreeCAD \
             (Mesh workbench, Create mesh from shape), and read that"
        }
        "brep" | "x_t" | "x_b" | "xt" | "sat" | "sab" | "sldprt" | "ipt" | "prt" | "catpart" | "fcstd" | "3dm"
        | "jt" | "ifc" => {
            "it holds a CAD model, not a mesh, and is not read; export a mesh (STL, OBJ, 3MF) from the program it comes from"
        }
        "inp" => {
            "Abaqus and CalculiX files are written only; convert it first, as with meshio (`meshio convert IN.inp OUT.vtu`), and read that"
        }
        "bdf" | "nas" | "fem" => {
            "Nastran files are written only; convert it first, as with meshio (`meshio convert IN.bdf OUT.vtu`), and read that"
        }
        "gz" | "tgz" | "zip" | "bz2" | "xz" | "zst" | "7z" | "rar" | "tar" => {
            "it is compressed; unpack it first, as with `gunzip`, `unzip` or `tar`, and read the file in it"
        }
        "fbx" | "dae" | "blend" | "3ds" | "usd" | "usdz" | "usda" | "usdc" | "x3d" | "wrl" | "dxf" | "max" | "ma"
        | "mb" | "c4d" | "skp" | "ctm" | "amf" => "it is not read; export it as OBJ, glTF or PLY, from Blender for one",
        "xyz" | "pts" | "pcd" | "las" | "laz" | "e57" | "asc" => {
            "it holds points without faces; make a surface of them first, as with MeshLab (Screened Poisson) or CloudCompare"
        }
        "dcm" | "nii" | "nrrd" | "mha" | "mhd" | "tif" | "tiff" | "vti" => {
            "it holds an image, not a surface; extract a surface first, as with 3D Slicer or ParaView (Contour)"
        }
        "json" => "it may be a record: give that with --options",
        "cgr" | "cg" | "skel" | "swc" | "tgf" => "it holds a skeleton: `hex` and `view` take it",
        _ => return None,
    })
}
