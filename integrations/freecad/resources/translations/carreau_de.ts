<?xml version="1.0" encoding="utf-8"?>
<!DOCTYPE TS>
<TS version="2.1" language="de_DE">
<context>
    <name>carreau</name>
    <message>
        <source>Pieces</source>
        <translation>Teile</translation>
    </message>
    <message>
        <source>all: every piece; largest: the largest body and its cavities</source>
        <translation>all: jedes Teil; largest: der größte Körper und seine Hohlräume</translation>
    </message>
    <message>
        <source>Sharp edges above</source>
        <translation>Scharfe Kanten ab</translation>
    </message>
    <message>
        <source>Degrees; empty: creases at the size of the result; 180: none</source>
        <translation>Grad; leer: Knicke in der Größe des Ergebnisses; 180: keine</translation>
    </message>
    <message>
        <source>CAD model</source>
        <translation>CAD-Modell</translation>
    </message>
    <message>
        <source>A solid with exact faces, named and coloured by their kind</source>
        <translation>Ein Volumenkörper mit exakten Flächen, nach ihrer Art benannt und gefärbt</translation>
    </message>
    <message>
        <source>Quads</source>
        <translation>Vierecke</translation>
    </message>
    <message>
        <source>A mesh of quads that keeps every sharp edge</source>
        <translation>Ein Netz aus Vierecken, das jede scharfe Kante behält</translation>
    </message>
    <message>
        <source>Remesh</source>
        <translation>Neu vernetzen</translation>
    </message>
    <message>
        <source>A graded mesh of fewer triangles that keeps every sharp edge</source>
        <translation>Ein abgestuftes Netz aus weniger Dreiecken, das jede scharfe Kante behält</translation>
    </message>
    <message>
        <source>Segment</source>
        <translation>Zerlegen</translation>
    </message>
    <message>
        <source>The faces of a part as a group of meshes, each with its surface</source>
        <translation>Die Flächen eines Teils als Gruppe von Netzen, jedes mit seiner Fläche</translation>
    </message>
    <message>
        <source>Hexes</source>
        <translation>Hexaeder</translation>
    </message>
    <message>
        <source>A FEM mesh of hexahedra along the branches of a tubular part</source>
        <translation>Ein FEM-Netz aus Hexaedern entlang der Zweige eines röhrenförmigen Teils</translation>
    </message>
    <message>
        <source>Prepare</source>
        <translation>Vorbereiten</translation>
    </message>
    <message>
        <source>Welds, orients and drops what is degenerate or there twice</source>
        <translation>Verschweißt, richtet aus und entfernt Entartetes und Doppeltes</translation>
    </message>
    <message>
        <source>Info</source>
        <translation>Auskunft</translation>
    </message>
    <message>
        <source>Counts, topology and defects with their places</source>
        <translation>Anzahlen, Topologie und Fehler mit ihren Orten</translation>
    </message>
    <message>
        <source>Tolerance</source>
        <translation>Toleranz</translation>
    </message>
    <message>
        <source>Largest distance of a vertex from its face; empty: from the data</source>
        <translation>Größter Abstand eines Knotens von seiner Fläche; leer: aus den Daten</translation>
    </message>
    <message>
        <source>Number of quads</source>
        <translation>Anzahl der Vierecke</translation>
    </message>
    <message>
        <source>Met within 10 % where the sharp edges allow it</source>
        <translation>Auf 10 % genau, wo die scharfen Kanten es zulassen</translation>
    </message>
    <message>
        <source>Symmetry</source>
        <translation>Symmetrie</translation>
    </message>
    <message>
        <source>x, y, z: across that axis; auto: across the planes of symmetry that the mesh has</source>
        <translation>x, y, z: über diese Achse; auto: über die Symmetrieebenen, die das Netz hat</translation>
    </message>
    <message>
        <source>Adaptive sizes</source>
        <translation>Angepasste Größen</translation>
    </message>
    <message>
        <source>Smaller quads where the surface bends</source>
        <translation>Kleinere Vierecke, wo sich die Fläche krümmt</translation>
    </message>
    <message>
        <source>As a mesh of triangles</source>
        <translation>Als Netz aus Dreiecken</translation>
    </message>
    <message>
        <source>Each quad cut in two, for the Mesh workbench</source>
        <translation>Jedes Viereck zweigeteilt, für den Arbeitsbereich Mesh</translation>
    </message>
    <message>
        <source>Angle to the surface</source>
        <translation>Winkel zur Fläche</translation>
    </message>
    <message>
        <source>Degrees between edges and the surface; empty: 14</source>
        <translation>Grad zwischen Kanten und Fläche; leer: 14</translation>
    </message>
    <message>
        <source>Number of triangles</source>
        <translation>Anzahl der Dreiecke</translation>
    </message>
    <message>
        <source>In place of the angle; 0: as many as the angle takes</source>
        <translation>Anstelle des Winkels; 0: so viele, wie der Winkel braucht</translation>
    </message>
    <message>
        <source>Number of faces</source>
        <translation>Anzahl der Flächen</translation>
    </message>
    <message>
        <source>Faces are merged down to this number; 0: from the data</source>
        <translation>Flächen werden bis zu dieser Anzahl vereinigt; 0: aus den Daten</translation>
    </message>
    <message>
        <source>Number of cells</source>
        <translation>Anzahl der Zellen</translation>
    </message>
    <message>
        <source>About this many, at most; 0: from the shape</source>
        <translation>Höchstens etwa so viele; 0: nach der Form</translation>
    </message>
    <message>
        <source>Layer on the boundary</source>
        <translation>Schicht am Rand</translation>
    </message>
    <message>
        <source>Where one more layer of cells goes</source>
        <translation>Wo eine weitere Schicht von Zellen liegt</translation>
    </message>
    <message>
        <source>Weld below</source>
        <translation>Verschweißen unter</translation>
    </message>
    <message>
        <source>Vertices nearer than this become one; empty: those at equal positions</source>
        <translation>Knoten, die näher beieinander liegen, werden einer; leer: die am selben Ort</translation>
    </message>
    <message>
        <source>Fill holes</source>
        <translation>Löcher schließen</translation>
    </message>
    <message>
        <source>All of them, by the least area, smoothed like the surroundings</source>
        <translation>Alle, mit kleinster Fläche, glatt wie die Umgebung</translation>
    </message>
    <message>
        <source>Select one mesh first.</source>
        <translation>Zuerst ein Netz auswählen.</translation>
    </message>
    <message>
        <source>Ending …</source>
        <translation>Wird beendet …</translation>
    </message>
    <message>
        <source>the Python package, or the program on the PATH</source>
        <translation>das Python-Paket oder das Programm im PATH</translation>
    </message>
    <message>
        <source>all processors</source>
        <translation>alle Prozessoren</translation>
    </message>
    <message>
        <source>none</source>
        <translation>keine</translation>
    </message>
    <message>
        <source>Program</source>
        <translation>Programm</translation>
    </message>
    <message>
        <source>Threads</source>
        <translation>Threads</translation>
    </message>
    <message>
        <source>Deadline in seconds</source>
        <translation>Frist in Sekunden</translation>
    </message>
</context>
</TS>
