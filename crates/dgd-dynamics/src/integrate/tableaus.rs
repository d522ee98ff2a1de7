//! Coefficients of the Rosenbrock methods.

use super::rosenbrock::Tableau;

/// RODASP 4(3): six stages, L-stable, stiffly accurate, made to lose little order where a fast mode follows a moving input.
///
/// Steinebach, G. (1995), "Order-reduction of ROW-methods for DAEs and method of lines applications", Preprint 1741, TH
/// Darmstadt.
pub(crate) struct Rodasp;

impl Tableau for Rodasp {
    const STAGES: usize = 6;
    const GAMMA: f64 = 0.25;
    const ALPHA: [f64; 6] = [0.0, 0.75, 0.21, 0.63, 1.0, 1.0];
    const DRIFT: [f64; 6] = [0.25, -0.5, -0.023_504, -0.0362, 0.0, 0.0];
    const A: [[f64; 4]; 5] = [
        [0.0, 0.0, 0.0, 0.0],
        [3.0, 0.0, 0.0, 0.0],
        [1.831_036_793_486_759, 0.495_518_396_743_379_5, 0.0, 0.0],
        [
            2.304_376_582_692_669,
            -0.052_492_752_457_430_01,
            -1.176_798_761_832_782,
            0.0,
        ],
        [
            -7.170_454_962_423_024,
            -4.741_636_671_481_785,
            -16.310_026_313_309_71,
            -1.062_004_044_111_401,
        ],
    ];
    const C: [[f64; 5]; 6] = [
        [0.0, 0.0, 0.0, 0.0, 0.0],
        [-12.0, 0.0, 0.0, 0.0, 0.0],
        [
            -8.791_795_173_947_035,
            -2.207_865_586_973_518,
            0.0,
            0.0,
            0.0,
        ],
        [
            10.817_930_568_571_53,
            6.780_270_611_428_266,
            19.534_859_446_424_1,
            0.0,
            0.0,
        ],
        [
            34.190_950_067_496_76,
            15.496_711_537_259_63,
            54.747_608_759_641_3,
            14.160_053_921_485_34,
            0.0,
        ],
        [
            34.626_058_309_305_32,
            15.300_849_761_144_73,
            56.999_555_786_626_67,
            18.408_070_097_930_95,
            -5.714_285_714_285_717,
        ],
    ];
    /// Of order 3.
    const H: [[f64; 5]; 2] = [
        [
            25.098_767_037_085_89,
            11.620_131_043_618_67,
            28.491_483_077_146_26,
            -5.664_021_568_594_133,
            0.0,
        ],
        [
            1.638_054_557_396_973,
            -0.737_361_980_667_874_8,
            8.477_918_219_238_99,
            15.992_531_487_795_2,
            -1.882_352_941_176_471,
        ],
    ];

    #[inline(always)]
    fn root(error: f64) -> f64 {
        // The estimate is of third order.
        error.sqrt().sqrt()
    }
}

/// RODAS3 3(2): four stages of which the first two share one evaluation, L-stable, stiffly accurate.
///
/// Sandu, A. et al. (1997), "Benchmarking stiff ODE solvers for atmospheric chemistry problems II: Rosenbrock solvers",
/// Atmospheric Environment 31, 3459-3472.
pub(crate) struct Rodas3;

impl Tableau for Rodas3 {
    const STAGES: usize = 4;
    const GAMMA: f64 = 0.5;
    const ALPHA: [f64; 6] = [0.0, 0.0, 1.0, 1.0, 0.0, 0.0];
    const DRIFT: [f64; 6] = [0.5, 1.5, 0.0, 0.0, 0.0, 0.0];
    const A: [[f64; 4]; 5] = [
        [0.0, 0.0, 0.0, 0.0],
        [0.0, 0.0, 0.0, 0.0],
        [2.0, 0.0, 0.0, 0.0],
        [0.0, 0.0, 0.0, 0.0],
        [0.0, 0.0, 0.0, 0.0],
    ];
    const C: [[f64; 5]; 6] = [
        [0.0, 0.0, 0.0, 0.0, 0.0],
        [4.0, 0.0, 0.0, 0.0, 0.0],
        [1.0, -1.0, 0.0, 0.0, 0.0],
        [1.0, -1.0, -8.0 / 3.0, 0.0, 0.0],
        [0.0, 0.0, 0.0, 0.0, 0.0],
        [0.0, 0.0, 0.0, 0.0, 0.0],
    ];
    /// Of order 2, and exact where the rate depends on time alone by a square: `b(θ)` with `Σ b_i = θ`, `Σ b_i β_i = θ²/2`,
    /// `Σ b_i α_i² = θ³/3`. The fourth condition of order 3 holds at the end alone.
    const H: [[f64; 5]; 2] = [[3.0, -1.0, -1.0, -1.0, 0.0], [0.0, 0.0, -1.0, -1.0, 0.0]];

    #[inline(always)]
    fn root(error: f64) -> f64 {
        // The estimate is of second order.
        error.cbrt()
    }
}
