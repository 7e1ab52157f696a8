MODULE WbLeft
    ! The left arm; loaded into T_ROB_L beside WbMove.

    CONST num my_arm:=2;
    CONST string my_name:="left";
    CONST jointtarget my_home:=[[0,-130,30,0,40,0],[135,9E9,9E9,9E9,9E9,9E9]];

    PROC main()
        wb_obey;
    ENDPROC
ENDMODULE
