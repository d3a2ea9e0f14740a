//! What rays make of cells, what moves with the grid, and what is refused.

use proptest::prelude::*;

use super::*;

const AGE: Duration = Duration::from_secs(10);

fn at(grid: &RollingGrid, point: (f64, f64), now: Duration) -> Occupancy {
    let mut data = vec![0; grid.geometry().cells()];
    grid.write_ros(now, AGE, &mut data);
    let cell = grid.geometry().cell_at(point);
    cell.map_or(Occupancy::Unknown, |cell| {
        Occupancy::from_ros(data[grid.geometry().index(cell)])
    })
}

fn grid() -> RollingGrid {
    RollingGrid::new(40, 0.1).expect("valid")
}

#[test]
fn a_ray_makes_its_cells_free_and_its_end_occupied() {
    let mut grid = grid();
    let ray = Ray {
        end: (1.05, 0.05),
        hit: true,
    };
    grid.observe((0.05, 0.05), [ray], Duration::ZERO);
    for (point, state) in [
        ((0.05, 0.05), Occupancy::Free),
        ((0.95, 0.05), Occupancy::Free),
        ((1.05, 0.05), Occupancy::Occupied),
        ((1.15, 0.05), Occupancy::Unknown),
    ] {
        assert_eq!(at(&grid, point, Duration::ZERO), state, "{point:?}");
    }
}

#[test]
fn an_obstacle_that_goes_is_cleared_and_what_is_not_seen_ages() {
    let mut grid = grid();
    let scan = |grid: &mut RollingGrid, hit, second| {
        let end = if hit { (1.05, 0.05) } else { (1.55, 0.05) };
        grid.observe((0.05, 0.05), [Ray { end, hit }], Duration::from_secs(second));
    };
    (0..5).for_each(|second| scan(&mut grid, true, second));
    (5..15).for_each(|second| scan(&mut grid, false, second));
    assert_eq!(at(&grid, (1.05, 0.05), Duration::from_secs(14)), Occupancy::Free);
    assert_eq!(at(&grid, (1.05, 0.05), Duration::from_secs(24)), Occupancy::Free);
    assert_eq!(
        at(&grid, (1.05, 0.05), Duration::from_secs(25)),
        Occupancy::Unknown
    );
}

#[test]
fn a_wall_along_a_ray_stays() {
    let mut grid = grid();
    let rays = [
        Ray {
            end: (1.05, 0.05),
            hit: true,
        },
        Ray {
            end: (1.55, 0.08),
            hit: true,
        },
    ];
    grid.observe((0.05, 0.05), rays, Duration::ZERO);
    assert_eq!(at(&grid, (1.05, 0.05), Duration::ZERO), Occupancy::Occupied);
}

#[test]
fn cells_keep_their_place_when_the_grid_moves_and_are_forgotten_outside() {
    let mut grid = grid();
    let now = Duration::ZERO;
    grid.observe(
        (0.05, 0.05),
        [Ray {
            end: (1.05, 0.05),
            hit: true,
        }],
        now,
    );
    grid.follow((1.53, 0.2)).expect("a place");
    assert_eq!(at(&grid, (1.05, 0.05), now), Occupancy::Occupied);
    assert_eq!(at(&grid, (0.55, 0.05), now), Occupancy::Free);
    grid.follow((100.0, -50.0)).expect("a place");
    grid.follow((0.0, 0.0)).expect("a place");
    assert_eq!(at(&grid, (1.05, 0.05), now), Occupancy::Unknown);
}

#[test]
fn the_boundary_is_what_is_occupied_or_unknown_beside_free_cells() {
    let mut grid = grid();
    let ray = Ray {
        end: (1.05, 0.05),
        hit: true,
    };
    grid.observe((0.05, 0.05), [ray], Duration::ZERO);
    let has = |grid: &RollingGrid, (x, y): (f64, f64)| {
        let boundary = grid.boundary((0.55, 0.05), 1.0);
        boundary
            .iter()
            .any(|at| (at.0 - x).abs() < 1e-6 && (at.1 - y).abs() < 1e-6)
    };
    assert!(has(&grid, (0.55, 0.15)), "unknown beside the ray");
    assert!(!has(&grid, (1.05, 0.05)), "the newest scan knows better");
    grid.observe((0.05, 0.05), [], Duration::ZERO);
    assert!(has(&grid, (1.05, 0.05)), "seen earlier");
    grid.assume_free((0.55, 0.05), 0.15, |_| true);
    assert!(!has(&grid, (0.55, 0.15)));
    grid.assume_free((1.05, 0.05), 0.3, |_| true);
    assert!(has(&grid, (1.05, 0.05)), "what was seen is not assumed away");
    grid.assume_free((-1e9, f64::NAN), 1e9, |_| false);
}

#[test]
fn what_went_out_of_sight_is_remembered_for_a_time() {
    let mut grid = grid();
    let ray = |end, hit| Ray { end, hit };
    let at = |grid: &RollingGrid, second| {
        let now = Duration::from_secs(second);
        grid.remembered((0.5, 0.0), 1.0, now, AGE).collect::<Vec<_>>()
    };
    grid.observe((0.05, 0.05), [ray((1.05, 0.05), true)], Duration::ZERO);
    assert_eq!(at(&grid, 0), [], "the newest scan knows better");
    grid.observe((0.05, 0.05), [ray((0.05, 1.05), false)], Duration::from_secs(1));
    let [(x, y)] = at(&grid, 10)[..] else {
        panic!("one cell")
    };
    assert!((x - 1.05).abs() < 1e-9 && (y - 0.05).abs() < 1e-9);
    assert_eq!(at(&grid, 11), []);
    (2..4).for_each(|second| {
        let through = [ray((1.55, 0.05), false)];
        grid.observe((0.05, 0.05), through, Duration::from_secs(second));
    });
    grid.observe((0.05, 0.05), [ray((1.55, 0.05), false)], Duration::from_secs(4));
    assert_eq!(at(&grid, 4), [], "rays pass through it");
}

#[test]
fn what_is_cleared_is_unknown_until_it_is_seen_again() {
    let mut grid = grid();
    let (now, end) = (Duration::ZERO, (1.05, 0.05));
    grid.observe((0.05, 0.05), [Ray { end, hit: true }], now);
    for (place, state) in [
        ((0.05, 0.05), Occupancy::Occupied),
        ((f64::NAN, 0.0), Occupancy::Occupied),
        ((0.55, 0.05), Occupancy::Unknown),
    ] {
        grid.clear(place, 0.6);
        assert_eq!(at(&grid, end, now), state, "{place:?}");
    }
    assert_eq!(at(&grid, (0.55, 0.05), now), Occupancy::Free);
    grid.observe((0.05, 0.05), [Ray { end, hit: true }], now);
    assert_eq!(at(&grid, end, now), Occupancy::Occupied);
}

#[test]
fn places_and_rays_that_are_not_finite_change_nothing() {
    let mut grid = grid();
    let before = *grid.geometry();
    for place in [(f64::NAN, 0.0), (0.0, f64::INFINITY), (1e300, 0.0)] {
        assert!(grid.follow(place).is_err(), "{place:?}");
        grid.observe(
            place,
            [Ray {
                end: (0.0, 0.0),
                hit: true,
            }],
            Duration::ZERO,
        );
    }
    grid.observe(
        (0.0, 0.0),
        [Ray {
            end: (f64::NAN, 0.0),
            hit: true,
        }],
        Duration::ZERO,
    );
    assert_eq!(*grid.geometry(), before);
    assert_eq!(at(&grid, (0.0, 0.0), Duration::ZERO), Occupancy::Unknown);
    assert!(RollingGrid::new(0, 0.1).is_err());
}

proptest! {
    #[test]
    fn rays_that_leave_the_grid_are_cut_and_mark_nothing(angle in -3.2..3.2f64, length in 3.0..1e6f64) {
        let mut grid = grid();
        let end = (length * angle.cos(), length * angle.sin());
        grid.observe((0.05, 0.05), [Ray { end, hit: true }], Duration::ZERO);
        let mut data = vec![0; grid.geometry().cells()];
        grid.write_ros(Duration::ZERO, AGE, &mut data);
        prop_assert!(!data.contains(&Occupancy::Occupied.to_ros()));
        // From the middle to an edge.
        prop_assert!(data.iter().filter(|&&number| number == Occupancy::Free.to_ros()).count() >= 19);
    }
}
