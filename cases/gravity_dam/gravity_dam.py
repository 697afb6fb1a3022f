"""gravity_dam.py: writes gravity_dam.msh, a dam of 30 m, 24 m wide at its base, on a block of rock of 120 m x 40 m."""
import gmsh

gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
model, geo = gmsh.model, gmsh.model.geo
near, far = 3.0, 15.0
heel, toe, crest = [geo.addPoint(*at, 0, near) for at in [(0, 0), (24, 0), (0, 30)]]
rock = [geo.addPoint(*at, 0, far) for at in [(-48, 0), (-48, -40), (72, -40), (72, 0)]]
base = geo.addLine(toe, heel)  # the normal of its facets, to the right of their way, points up
downstream, upstream = geo.addLine(toe, crest), geo.addLine(crest, heel)
dam = geo.addPlaneSurface([geo.addCurveLoop([downstream, upstream, -base])])
bed = geo.addLine(heel, rock[0])
sides = [geo.addLine(rock[i], rock[i + 1]) for i in range(3)]
bank = geo.addLine(rock[3], toe)
ground = geo.addPlaneSurface([geo.addCurveLoop([bed, *sides, bank, base])])
geo.synchronize()
for name, dim, tags in [
    ("dam", 2, [dam]), ("rock", 2, [ground]), ("base", 1, [base]), ("upstream", 1, [upstream]), ("bed", 1, [bed]),
    ("flanks", 1, [sides[0], sides[2]]), ("foot", 1, [sides[1]]),
]:
    model.addPhysicalGroup(dim, tags, name=name)
model.mesh.generate(2)
gmsh.write("gravity_dam.msh")
