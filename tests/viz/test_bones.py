import numpy as np
import pytest
import trimesh

from kneeviz.geometry import bones as geometry

SQUARE = np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]])


def area(loop):
    nxt = np.roll(loop, -1, axis=0)
    return 0.5 * float((loop[:, 0] * nxt[:, 1] - loop[:, 1] * nxt[:, 0]).sum())


class TestSmoothLoop:
    def test_passes_through_its_points(self):
        curve = geometry.smooth_loop(SQUARE, samples=5)
        assert curve.shape == (20, 2)
        np.testing.assert_allclose(curve[::5], SQUARE, atol=1e-12)

    def test_points_on_a_circle_give_a_circle(self):
        angle = np.linspace(0, 2 * np.pi, 24, endpoint=False)
        curve = geometry.smooth_loop(np.column_stack([np.cos(angle), np.sin(angle)]))
        np.testing.assert_allclose(np.linalg.norm(curve, axis=1), 1.0, atol=2e-3)

    def test_uneven_spacing_does_not_overshoot(self):
        uneven = np.array([[0.0, 0.0], [0.2, 0.0], [10.0, 0.0], [5.0, 5.0]])
        curve = geometry.smooth_loop(uneven, samples=20)
        assert curve[:, 1].min() > -0.8
        assert curve[:, 0].max() < 10.6


class TestInsideAndDistance:
    def test_known_points(self):
        points = np.array([[5.0, 5.0], [-1.0, 5.0], [5.0, 11.0], [9.9, 0.1]])
        assert geometry.inside(points, SQUARE).tolist() == [True, False, False, True]

    def test_distance_to_edges_and_corners(self):
        points = np.array([[5.0, 5.0], [13.0, 14.0], [2.0, 9.0]])
        np.testing.assert_allclose(geometry.distance_to_loop(points, SQUARE), [5.0, 5.0, 1.0])


class TestMeshes:
    def test_triangles_fill_the_outline_once(self):
        loop = geometry.smooth_loop(SQUARE)
        points, triangles = geometry.triangulate(loop, spacing=1.0)
        a, b, c = (points[triangles[:, i]] for i in range(3))
        one, two = b - a, c - a
        signed = 0.5 * (one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0])
        assert (signed > 0).all()
        assert signed.sum() == pytest.approx(area(loop), rel=1e-9)

    def test_bulge_has_its_depth_and_a_thin_rim(self):
        vertices, _ = geometry.bulge(100 * SQUARE, depth=30.0, centre=5.0)
        assert vertices[:, 2].max() == pytest.approx(35.0)
        assert vertices[:, 2].min() == pytest.approx(-25.0)
        rim = geometry.distance_to_loop(vertices[:, :2], 100 * SQUARE) < 1e-9
        np.testing.assert_allclose(np.abs(vertices[rim, 2] - 5.0), 3.0)


class TestPackagedBones:
    def test_three_bones_in_their_frames(self):
        assert {b.name: b.frame for b in geometry.bones()} == {
            "femur": "femur",
            "tibia": "tibia",
            "fibula": "tibia",
        }

    @pytest.mark.parametrize("bone", geometry.bones(), ids=lambda b: b.name)
    def test_meshes_are_closed_and_in_metres(self, bone):
        mesh = trimesh.Trimesh(bone.vertices, bone.faces, process=False)
        assert mesh.is_watertight
        assert mesh.is_winding_consistent
        assert mesh.volume > 0
        assert 0.05 < np.ptp(bone.outline[:, 1]) < 0.25

    def test_the_condyle_follows_the_models_circle(self):
        """Between the distal and the posterior end the outline is the circle, to 2 mm."""
        outline = next(b for b in geometry.bones() if b.name == "femur").outline
        angle = np.degrees(np.arctan2(outline[:, 1], outline[:, 0]))
        arc = outline[(angle > -178) & (angle < -85)]
        assert len(arc) > 10
        np.testing.assert_allclose(np.linalg.norm(arc, axis=1), 0.0321, atol=0.002)
