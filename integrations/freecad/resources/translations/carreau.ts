<?xml version="1.0" encoding="utf-8"?>
<!DOCTYPE TS>
<TS version="2.1">
<context>
    <name>carreau</name>
    <message>
        <source>Pieces</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>all: every piece; largest: the largest body and its cavities</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Sharp edges above</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Degrees; empty: creases at the size of the result; 180: none</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>CAD model</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>A solid with exact faces, named and coloured by their kind</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Quads</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>A mesh of quads that keeps every sharp edge</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Remesh</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>A graded mesh of fewer triangles that keeps every sharp edge</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Segment</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>The faces of a part as a group of meshes, each with its surface</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Hexes</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>A FEM mesh of hexahedra along the branches of a tubular part</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Prepare</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Welds, orients and drops what is degenerate or there twice</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Info</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Counts, topology and defects with their places</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Tolerance</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Largest distance of a vertex from its face; empty: from the data</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Number of quads</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Met within 10 % where the sharp edges allow it</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Symmetry</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>x, y, z: across that axis; auto: across the planes of symmetry that the mesh has</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Adaptive sizes</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Smaller quads where the surface bends</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>As a mesh of triangles</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Each quad cut in two, for the Mesh workbench</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Angle to the surface</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Degrees between edges and the surface; empty: 14</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Number of triangles</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>In place of the angle; 0: as many as the angle takes</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Number of faces</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Faces are merged down to this number; 0: from the data</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Number of cells</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>About this many, at most; 0: from the shape</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Layer on the boundary</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Where one more layer of cells goes</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Weld below</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Vertices nearer than this become one; empty: those at equal positions</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Fill holes</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>All of them, by the least area, smoothed like the surroundings</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Select one mesh first.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Ending …</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>the Python package, or the program on the PATH</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>all processors</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>none</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Program</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Threads</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Deadline in seconds</source>
        <translation type="unfinished"></translation>
    </message>
</context>
</TS>
