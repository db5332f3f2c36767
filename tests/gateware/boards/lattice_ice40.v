// The iCE40's clock and I/O primitives as arcref uses them, written from Lattice's iCE40 Technology Library and
// FPGA-TN-02052 (sysCLOCK PLL).
`timescale 1ps/1ps

module ice40_pll_model #(parameter integer DIVR = 0, DIVF = 0, DIVQ = 1) (
    input reference_clock, output reg clock, locked
);
    realtime edge_before, period;
    integer edges;
    initial begin clock = 0; locked = 0; edges = 0; period = 0; end
    always @(posedge reference_clock) begin
        if (edges > 0) period = ($realtime - edge_before) * (DIVR + 1) * (1 << DIVQ) / (DIVF + 1);
        edge_before = $realtime;
        edges = edges + 1;
        if (edges == 20) locked <= 1;
    end
    initial begin
        wait (period > 0);
        forever begin #(period / 2); clock = ~clock; end
    end
endmodule

module SB_PLL40_2_PAD #(
    parameter [3:0] DIVR = 0, parameter [6:0] DIVF = 0, parameter [2:0] DIVQ = 1, FILTER_RANGE = 0,
    parameter FEEDBACK_PATH = "SIMPLE", PLLOUT_SELECT_PORTB = "GENCLK"
) (
    input PACKAGEPIN, RESETB, BYPASS, output PLLOUTGLOBALA, PLLOUTGLOBALB, LOCK
);
    assign PLLOUTGLOBALA = PACKAGEPIN;
    ice40_pll_model #(.DIVR(DIVR), .DIVF(DIVF), .DIVQ(DIVQ)) pll (
        .reference_clock(PACKAGEPIN), .clock(PLLOUTGLOBALB), .locked(LOCK));
endmodule

module SB_PLL40_CORE #(
    parameter [3:0] DIVR = 0, parameter [6:0] DIVF = 0, parameter [2:0] DIVQ = 1, FILTER_RANGE = 0,
    parameter FEEDBACK_PATH = "SIMPLE", PLLOUT_SELECT = "GENCLK"
) (
    input REFERENCECLK, RESETB, BYPASS, output PLLOUTGLOBAL, LOCK
);
    ice40_pll_model #(.DIVR(DIVR), .DIVF(DIVF), .DIVQ(DIVQ)) pll (
        .reference_clock(REFERENCECLK), .clock(PLLOUTGLOBAL), .locked(LOCK));
endmodule

// PIN_TYPE[1:0]: 00 registered (D_IN_0 at the rising edge, D_IN_1 at the falling one), 01 as it comes.
// PIN_TYPE[5:2]: 0000 no output, 1100 double data rate with registered enable.
// A fault, chosen when the simulation is run: +order=1 exchanges the two samples.
module SB_IO #(
    parameter [5:0] PIN_TYPE = 0, parameter [0:0] PULLUP = 0, parameter IO_STANDARD = "SB_LVCMOS"
) (
    inout PACKAGE_PIN, input INPUT_CLK, OUTPUT_CLK, OUTPUT_ENABLE, D_OUT_0, D_OUT_1, output D_IN_0, D_IN_1
);
    reg rising, falling, out_0, out_1, enable;
    initial enable = 0;
    always @(posedge INPUT_CLK) rising <= PACKAGE_PIN;
    always @(negedge INPUT_CLK) falling <= PACKAGE_PIN;
    integer order;
    initial if (!$value$plusargs("order=%d", order)) order = 10;
    assign D_IN_0 = PIN_TYPE[0] ? PACKAGE_PIN : (order == 10 ? rising : falling);
    assign D_IN_1 = order == 10 ? falling : rising;
    always @(posedge OUTPUT_CLK) begin out_0 <= D_OUT_0; enable <= OUTPUT_ENABLE; end
    always @(negedge OUTPUT_CLK) out_1 <= D_OUT_1;
    assign PACKAGE_PIN = (PIN_TYPE[5:2] == 4'b1100 && enable) ? (OUTPUT_CLK ? out_0 : out_1) : 1'bz;
endmodule

module SB_GB_IO #(
    parameter [5:0] PIN_TYPE = 0, parameter IO_STANDARD = "SB_LVCMOS"
) (
    inout PACKAGE_PIN, output GLOBAL_BUFFER_OUTPUT
);
    assign GLOBAL_BUFFER_OUTPUT = PACKAGE_PIN;
endmodule

module SB_DFF (input C, D, output reg Q);
    always @(posedge C) Q <= D;
endmodule
