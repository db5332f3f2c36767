// The ECP5's clock and I/O primitives as arcref uses them, written from Lattice's descriptions:
// FPGA-TN-02035 (high-speed I/O: IDDRX1F, IDDRX2F, ECLKSYNCB), FPGA-TN-02200 (sysCLOCK: EHXPLLL, CLKDIVF).
`timescale 1ps/1ps

// PLL with the feedback from CLKOP. Its outputs run before it is locked, as those of the part may.
module EHXPLLL #(
    parameter integer CLKI_DIV = 1, CLKFB_DIV = 1, CLKOP_DIV = 8, CLKOP_CPHASE = 0, CLKOP_FPHASE = 0,
    parameter integer CLKOS_DIV = 8, CLKOS_CPHASE = 0, CLKOS_FPHASE = 0,
    parameter PLLRST_ENA = "DISABLED", INTFB_WAKE = "DISABLED", STDBY_ENABLE = "DISABLED", DPHASE_SOURCE = "DISABLED",
    parameter OUTDIVIDER_MUXA = "DIVA", OUTDIVIDER_MUXB = "DIVB", FEEDBK_PATH = "CLKOP",
    parameter CLKOP_ENABLE = "ENABLED", CLKOS_ENABLE = "ENABLED"
) (
    input CLKI, CLKFB, RST, STDBY, PHASESEL0, PHASESEL1, PHASEDIR, PHASESTEP, PHASELOADREG, PLLWAKESYNC,
    input ENCLKOP, ENCLKOS,
    output reg CLKOP, CLKOS, LOCK
);
    realtime edge_before, reference, vco;
    integer op_left, os_left, edges;
    initial begin
        CLKOP = 0; CLKOS = 0; LOCK = 0; edges = 0; vco = 0; op_left = 1; os_left = 1;
    end
    always @(posedge CLKI) begin
        if (edges > 0) begin
            reference = $realtime - edge_before;
            vco = reference * CLKI_DIV / (CLKFB_DIV * CLKOP_DIV);
        end
        edge_before = $realtime;
        edges = edges + 1;
        if (edges == 20) LOCK <= 1;
    end
    initial begin
        wait (vco > 0);
        forever begin
            #(vco / 2);
            op_left = op_left - 1;
            if (op_left == 0) begin CLKOP = ~CLKOP; op_left = CLKOP_DIV; end
            os_left = os_left - 1;
            if (os_left == 0) begin CLKOS = ~CLKOS; os_left = CLKOS_DIV; end
        end
    end
endmodule

// Faults, chosen when the simulation is run: +order=3210 permutes the outputs of IDDRX2F and +order=10 those of IDDRX1F
// (place k of the word shows sample number order[k]), +never_stop runs the edge clock through the start-up,
// +late_reset=NAME lets the reset of one input's gearing go 2.5 ns late (an edge clock at 400 MHz).

// Stops the edge clock low, without a short pulse: STOP takes effect while the clock is low.
module ECLKSYNCB (input ECLKI, STOP, output ECLKO);
    reg first, run;
    initial begin first = 0; run = 0; end
    always @(negedge ECLKI) begin first <= ~STOP | $test$plusargs("never_stop") != 0; run <= first; end
    assign ECLKO = ECLKI & run;
endmodule

module CLKDIVF #(parameter DIV = "2.0", GSR = "DISABLED") (input CLKI, RST, ALIGNWD, output reg CDIVX);
    initial CDIVX = 0;
    always @(posedge CLKI or posedge RST)
        if (RST) CDIVX <= 0;
        else CDIVX <= #50 ~CDIVX;
endmodule

module IDDRX1F (input D, SCLK, RST, output reg Q0, Q1);
    reg rising, falling;
    integer order;
    initial if (!$value$plusargs("order=%d", order)) order = 10;
    always @(posedge SCLK or posedge RST)
        if (RST) begin rising <= 0; Q0 <= 0; Q1 <= 0; end
        else begin
            rising <= D;
            Q0 <= order == 10 ? rising : falling;
            Q1 <= order == 10 ? falling : rising;
        end
    always @(negedge SCLK or posedge RST) if (RST) falling <= 0; else falling <= D;
endmodule

// Two samples each edge clock; two pairs make a word, which the word clock takes over, Q0 the oldest.
// Which pairs belong together is told by a flip-flop that the reset clears.
module IDDRX2F (input D, ECLK, SCLK, RST, output reg Q0, Q1, Q2, Q3);
    reg rising, falling, older_rising, older_falling, second;
    reg [3:0] word;
    reg late, late_reset;
    string place, late_name;
    integer order, k;
    initial begin
        if (!$value$plusargs("order=%d", order)) order = 3210;
        place = $sformatf("%m");
        late = 0;
        late_reset = 1;
        if ($value$plusargs("late_reset=%s", late_name))
            for (k = 0; k + late_name.len() <= place.len(); k = k + 1)
                if (place.substr(k, k + late_name.len() - 1) == late_name) late = 1;
    end
    always @(RST) late_reset <= #2500 RST;
    wire reset = RST | (late & late_reset);
    function bit chosen(input [3:0] samples, input integer digit);
        chosen = samples[2'(digit % 10)];
    endfunction
    always @(negedge ECLK or posedge reset) if (reset) falling <= 0; else falling <= D;
    always @(posedge ECLK or posedge reset)
        if (reset) begin
            rising <= 0; older_rising <= 0; older_falling <= 0; second <= 0; word <= 0;
        end else begin
            rising <= D;
            older_rising <= rising;
            older_falling <= falling;
            second <= ~second;
            if (second) word <= {falling, rising, older_falling, older_rising};
        end
    always @(posedge SCLK or posedge RST)
        if (RST) {Q3, Q2, Q1, Q0} <= 0;
        else begin
            Q0 <= chosen(word, order);
            Q1 <= chosen(word, order / 10);
            Q2 <= chosen(word, order / 100);
            Q3 <= chosen(word, order / 1000);
        end
endmodule

module IB (input I, output O);
    assign O = I;
endmodule

module BB (input I, T, output O, inout B);
    assign B = T ? 1'bz : I;
    assign O = B;
endmodule

module FD1S3BX #(parameter GSR = "DISABLED") (input CK, D, PD, output reg Q);
    initial Q = 1;
    always @(posedge CK or posedge PD) if (PD) Q <= 1; else Q <= D;
endmodule
