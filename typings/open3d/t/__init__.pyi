from open3d.t import geometry as geometry
